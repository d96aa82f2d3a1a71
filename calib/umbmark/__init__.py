"""UMBmark: square runs, return errors, the correction of the truck, and its uncertainty."""
