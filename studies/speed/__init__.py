"""Benchmarks of time and memory, each as a ratio against a peer that is measured in the same run."""
