"""Export of drives and frames: MCAP, ROS 2 bags, TUM trajectories, Parquet tables."""
