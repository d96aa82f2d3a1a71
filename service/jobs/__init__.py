"""Diagnoses as jobs: one at a time, in a process of their own, retried when they die."""
