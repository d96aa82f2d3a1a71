"""What is known of an ordinary floor.

A wheel's travel over a floor scatters with the square root of the way, independently for each wheel; the
roughness is its standard deviation after one metre [m/sqrt(m)]. Source of the law: Chong & Kleeman, Accurate
odometry and error modelling for a mobile robot, ICRA 1997.
"""

# [m/sqrt(m)] With a wheelbase of 340 mm it makes the return position of a 4 x 4 m square scatter by 25 mm in
# x and in y, as U V reports: shown by `pytest tests/vcan_sim/test_floor.py`. The heading then scatters by
# 0.54 degrees.
CONCRETE_ROUGHNESS = 5.6e-4
