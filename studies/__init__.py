"""Studies, from a checkout only: the papers reproduced, the mismatch tool proven, accuracy and speed."""
