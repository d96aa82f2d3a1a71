"""`omnimate demo`: its call, the drives on a virtual bus, and its table and figures."""
