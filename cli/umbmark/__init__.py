"""`omnimate umbmark`: its call, its sources, its results, and how they are printed and handed on."""
