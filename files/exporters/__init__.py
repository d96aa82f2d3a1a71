"""Drives and frames for other tools: MCAP, ROS 2 bags, trajectories as TUM, tables as Parquet."""
