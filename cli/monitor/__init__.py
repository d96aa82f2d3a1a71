"""`omnimate monitor`: a bus as it lives, in a terminal."""
