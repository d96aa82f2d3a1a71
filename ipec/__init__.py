"""Recordings or live streams as corrected trajectories: each truck's heading corrected through the other.

The correctors follow the papers' equations (`corrector`, `corrections`); the folder `filter` holds a
Kalman filter and a smoother over all seven encoders; `tracker` runs all of them side by side.
"""
