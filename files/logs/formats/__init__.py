"""Line formats and files of bus logs: candump, those that python-can reads, and MiniMon."""
