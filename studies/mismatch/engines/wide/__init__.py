"""The own engine with other draws: robots, drives, floors and measurements from wide distributions.

They are so wide that the sets of other simulators and of real robots lie inside: small robots and large ones,
10 to 100 samples a second, encoders of 1024 counts that jitter, floors whose roughness spans a factor of 40,
poses that are absent, sparse, dense, worse than they state, off the centre, or late.
"""
