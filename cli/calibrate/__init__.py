"""`omnimate calibrate`: its call, and the tables and sentences that it prints."""
