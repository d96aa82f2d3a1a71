"""The calls of the REST interface, one file for each kind of object."""
