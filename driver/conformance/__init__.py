"""Conformance checks of any node by raw frames: CiA 301, 305, 402 and 406."""
