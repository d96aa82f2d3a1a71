"""What has no name is learned: a short formula, or a smooth curve, of what the robot does.

`learn.learn` asks for the leftover of a recording and answers with an effect `law`, or with nothing.
"""
