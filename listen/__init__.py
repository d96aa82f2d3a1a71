"""Learns what is on an unknown bus: nodes, PDOs, the layout of their data, wheels. Sends nothing."""
