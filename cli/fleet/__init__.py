"""`omnimate fleet`: the recordings of many robots, processed every day."""
