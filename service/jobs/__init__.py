"""Diagnoses as jobs: one at a time, each in its own process, and tried again when the process dies."""
