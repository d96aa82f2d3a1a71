"""Recordings from other sources: public data sets, CSV files, ROS bags."""
