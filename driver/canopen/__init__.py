"""CANopen services of a master: SDO, NMT, LSS, PDO parameters, EDS and DCF files."""
