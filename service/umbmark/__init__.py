"""UMBmark sessions: their requests and responses, states, runs and results."""
