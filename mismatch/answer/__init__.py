"""From the best set to findings with probabilities, parameters, words and held-out residuals."""
