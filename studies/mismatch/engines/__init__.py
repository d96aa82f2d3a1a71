"""The proof: recordings with known faults, from engines that share nothing with the simulator."""
