"""A UMBmark session: what a client sends and gets, its states, its samples and its result."""
