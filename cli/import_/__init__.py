"""`omnimate import`: one verb for each kind of source, and what they say of the recordings."""
