"""An error-state Kalman filter over all seven encoders, live, and a smoother for whole recordings.

`live.Filter` takes sample by sample, `estimate.estimate` a whole recording with the same result, and
`smoother.smooth` uses the samples before and after each one.
"""
