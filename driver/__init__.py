"""The bus: CANopen encoders and drives in, samples and a recording out, wheel speeds back to the bus.

`omnimate.driver.driver.Driver` produces SYNC and reads the encoders; `omnimate.driver.passive.PassiveReader`
only listens where another master produces SYNC. Both use the same assembler, supervision and report.
"""
