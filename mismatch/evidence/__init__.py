"""What candidates are worth beside each other, and the search for the set that explains most."""
