"""The candidates: effects of the library, events, and errors without a name, as whitened columns."""
