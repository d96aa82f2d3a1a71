"""Laws of unknown errors, learned from residuals: a short formula, or a smooth curve."""
