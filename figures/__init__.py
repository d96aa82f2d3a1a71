"""Figures on which people compare: clusters of return errors, floor plans; and figures inside web pages."""
