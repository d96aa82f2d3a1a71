"""Readers of the OptiOdom data: a differential robot and a tricycle, with motion capture."""
