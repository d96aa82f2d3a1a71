"""What was on a bus, in files: frames, candump and foreign logs, samples made of them, recording folders."""
