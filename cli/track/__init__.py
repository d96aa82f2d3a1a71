"""`omnimate track`: its call, the rows that it writes, and what it says of poses and disturbances."""
