"""Diagnoses as jobs: one at a time, each in a separate process, and tried again when the process dies."""
