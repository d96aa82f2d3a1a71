"""Injections: real recordings altered to what a robot with an effect would have recorded."""
