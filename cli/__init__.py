"""The `omnimate` command: thin; every verb calls one function of a room."""
