"""Watching a bus without sending anything: what `omnimate monitor` shows."""
