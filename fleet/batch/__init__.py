"""The daily batch: every recording of a store once, by whatever workers, with the same results."""
