"""The bus: CANopen encoders and drives in, samples and a recording out, wheel speeds back to the bus.

`omnimate.driver.robot.driver.Driver` produces SYNC and reads the encoders;
`omnimate.driver.robot.passive.PassiveReader` only listens where another master produces SYNC.
Both use the same assembler, supervision and report.
"""
