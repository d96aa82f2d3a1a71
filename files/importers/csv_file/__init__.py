"""CSV files with a mapping that says which column holds which quantity."""
