"""Analysis of an unknown bus: nodes, PDOs, layout of their data, wheels. Nothing is sent."""
