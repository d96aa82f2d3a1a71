"""UMBmark: square runs, their return errors, the correction that they ask for, and how well it is known."""
