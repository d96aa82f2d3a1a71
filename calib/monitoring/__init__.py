"""Monitoring of calibrated robots: drift of repeated quantities, and frozen encoders."""
