"""The CANopen devices of the simulated vehicle: CiA 301 communication, CiA 406 encoders, CiA 402 drives."""
