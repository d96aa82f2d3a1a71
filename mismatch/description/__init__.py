"""Whether the robot is described grossly wrong: small effects are looked for after that."""
