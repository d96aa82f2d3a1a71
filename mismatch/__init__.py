"""Where simulation and recording differ, which physics was left out, its model, and how sure that is."""
