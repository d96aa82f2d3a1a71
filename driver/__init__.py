"""The bus: CANopen encoders and drives in, samples and a recording out, wheel speeds back to the bus.

`driver.driver.Driver` produces SYNC and reads the encoders; `driver.passive.PassiveReader` only listens
where somebody else produces it. Both use the same assembler, supervision and report.
"""
