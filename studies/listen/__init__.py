"""The accuracy of `omnimate listen` on buses that are simulated from EDS files."""
