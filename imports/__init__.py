"""Recording folders out of what people have: public data sets, CSV files, ROS bags."""
