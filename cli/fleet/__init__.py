"""`omnimate fleet`: the recordings of many robots, night after night."""
