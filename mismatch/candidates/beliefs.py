"""What is believed of every effect before a recording is seen.

The a-priori size of a fault stands with each parameter of an effect (`Parameter.scale`). Here stand how often
robots have it, how much of it every robot has, and how exact its law is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Belief:
    """What is believed of an effect.

    Attributes:
        odds: Prior odds that one component of a robot has it as a fault.
        everyday: Standard deviation of what every robot has of it, in sizes of a fault.
        inexact: Part by which it may act otherwise than its law says, on any stretch, one standard deviation.
        most: Sizes of a fault beyond which nobody believes in it: three standard deviations of a large one,
            or less where nothing in use is as bad.
    """

    odds: float
    everyday: float = 0.05
    inexact: float = 0.05
    most: float = 15.0

    @property
    def log_odds(self) -> float:
        """Logarithm of the prior odds."""
        return math.log(self.odds)


# With the Bayes factor's own penalty these odds let noise be told as one of a robot's eight numbers in one
# recording of two hundred, and as one of its sixty faults likewise: one false alarm in a hundred.
NUMBER = 0.03  # odds that one of the owner's numbers is wrong: what calibrations are for
NUMBERS = ("wheel_diameter", "wheelbase")  # of a truck, which one calibration gives together
UNCALIBRATED = 0.3  # odds that another one of them is wrong, too, if one is: the truck was not calibrated
FAULT = 0.005  # odds of a fault of one component
RARE = 0.002  # odds of what few workshops have ever met

BELIEFS: dict[str, Belief] = {
    "wheel_diameter": Belief(NUMBER, 0.01, 0.01),
    "wheelbase": Belief(NUMBER, 0.03, 0.02),
    "joint_bias": Belief(NUMBER, 0.01, 0.01),
    "link_bias": Belief(FAULT, 0.05, 0.01),
    "wheel_misalignment": Belief(FAULT, 0.01, 0.05),
    "wheel_eccentricity": Belief(FAULT, 0.05, 0.05),
    "radius_vs_speed": Belief(RARE, 0.05, 0.1),
    "radius_step": Belief(FAULT, 0.05, 0.05),
    "bump": Belief(FAULT, 0.03, 0.3, most=6.0),
    "slip_patch": Belief(FAULT, 0.05, 0.3),
    "traction_slip": Belief(FAULT, 0.05, 0.2),
    "turn_scrub": Belief(RARE, 0.01, 0.1),
    "lateral_slip": Belief(RARE, 0.05, 0.2),
    # 3 %: a ramp of 1 in 12 (ADA Standards 405.2), of which soft tyres creep by a third
    "floor_slope": Belief(FAULT, 0.03, 0.1, most=6.0),
    "castor_kick": Belief(FAULT, 0.1, 0.3),
    "joint_eccentricity": Belief(FAULT, 0.05, 0.05, most=6.0),
    "joint_backlash": Belief(FAULT, 0.05, 0.3),
    "link_eccentricity": Belief(RARE, 0.05, 0.05, most=5.0),
    "link_scale": Belief(RARE, 0.05, 0.05),
    "count_loss": Belief(FAULT, 0.01, 0.1),
    "latency": Belief(FAULT, 0.25, 0.05, most=5.0),
    "gear_backlash": Belief(FAULT, 0.05, 0.3),
    "gear_harmonic": Belief(FAULT, 0.05, 0.05),
    "clock_drift": Belief(FAULT, 0.02, 0.05, most=10.0),
    "unknown": Belief(RARE, 0.0, 0.1),
    "law": Belief(RARE, 0.0, 0.1),
    "reference_offset": Belief(1.0),  # of every measurement; it is fitted, and never searched for
}
