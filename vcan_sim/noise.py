"""Random numbers as a function of a seed, a stream and an index in this stream (counter-based).

A vehicle that is stepped live therefore has the same noise of the floor as one that is simulated without a
bus.
"""

import math

import numpy as np

from omnimate.vehicle.compiled import compiled

FLOOR, SONAR = range(2)  # numbers of the streams of truck a; for truck b, STREAMS is added
STREAMS = 2

# Constants of splitmix64: Steele, Lea & Flood, "Fast splittable pseudorandom number generators", 2014.
_GOLDEN = np.uint64(0x9E3779B97F4A7C15)  # 2^64 divided by the golden ratio, odd
_FIRST = np.uint64(0xBF58476D1CE4E5B9)
_SECOND = np.uint64(0x94D049BB133111EB)


@compiled
def _mix(bits: np.uint64) -> np.uint64:
    """Scramble 64 bits: the finaliser of splitmix64, Steele, Lea & Flood (2014)."""
    bits = (bits ^ (bits >> np.uint64(30))) * _FIRST
    bits = (bits ^ (bits >> np.uint64(27))) * _SECOND
    return np.uint64(bits ^ (bits >> np.uint64(31)))


@compiled
def _uniform(bits: np.uint64) -> float:
    """Return a number in (0, 1) from the upper 53 bits."""
    return (float(bits >> np.uint64(11)) + 0.5) * 2.0**-53


@compiled
def normal_pair(seed: int, stream: int, index: int) -> tuple[float, float]:
    """Return two independent standard normal deviates: number `index` of a stream, Box & Muller (1958)."""
    start = _mix(_mix(np.uint64(seed) + _GOLDEN) + np.uint64(stream) * _GOLDEN)
    state = start + np.uint64(2 * index) * _GOLDEN
    radius = math.sqrt(-2.0 * math.log(_uniform(_mix(state))))
    angle = 2.0 * math.pi * _uniform(_mix(state + _GOLDEN))
    return radius * math.cos(angle), radius * math.sin(angle)
