"""The bus, as samples: CANopen encoders configured, synchronised, supervised and recorded."""
