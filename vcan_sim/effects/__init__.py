"""The effects: physics that a nominal robot leaves out, used by the simulator and the diagnosis alike.

To add one, write its file and add its line to `EFFECTS`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from vcan_sim.effects.bump import BumpEvents
from vcan_sim.effects.castor_kick import CastorKick
from vcan_sim.effects.clock_drift import ClockDrift
from vcan_sim.effects.count_loss import CountLoss
from vcan_sim.effects.floor_slope import FloorSlope
from vcan_sim.effects.gear_backlash import GearBacklash
from vcan_sim.effects.gear_harmonic import GearHarmonic
from vcan_sim.effects.joint_backlash import JointBacklash
from vcan_sim.effects.joint_bias import JointBias
from vcan_sim.effects.joint_eccentricity import JointEccentricity
from vcan_sim.effects.latency import Latency
from vcan_sim.effects.lateral_slip import LateralSlip
from vcan_sim.effects.link_bias import LinkBias
from vcan_sim.effects.link_eccentricity import LinkEccentricity
from vcan_sim.effects.link_scale import LinkScale
from vcan_sim.effects.radius_step import RadiusStep
from vcan_sim.effects.radius_vs_speed import RadiusVsSpeed
from vcan_sim.effects.slip_patch import SlipPatch
from vcan_sim.effects.traction_slip import TractionSlip
from vcan_sim.effects.turn_scrub import TurnScrub
from vcan_sim.effects.wheel_diameter import WheelDiameter
from vcan_sim.effects.wheel_eccentricity import WheelEccentricity
from vcan_sim.effects.wheel_misalignment import WheelMisalignment
from vcan_sim.effects.wheelbase import Wheelbase
from vcan_sim.errors import SimulationError

if TYPE_CHECKING:
    from vcan_sim.effects.effect import Effect

EFFECTS: tuple[type[Effect], ...] = (
    WheelDiameter,
    WheelEccentricity,
    RadiusVsSpeed,
    RadiusStep,
    BumpEvents,
    SlipPatch,
    TractionSlip,
    Wheelbase,
    TurnScrub,
    WheelMisalignment,
    LateralSlip,
    FloorSlope,
    CastorKick,
    JointBias,
    JointEccentricity,
    JointBacklash,
    LinkBias,
    LinkEccentricity,
    LinkScale,
    CountLoss,
    Latency,
    GearBacklash,
    GearHarmonic,
    ClockDrift,
)


def effect_named(name: str) -> type[Effect]:
    """Return the kind of effect of a name.

    Raises:
        SimulationError: there is none.
    """
    for kind in EFFECTS:
        if kind.name == name:
            return kind
    known = ", ".join(sorted(kind.name for kind in EFFECTS))
    raise SimulationError(f"effect {name!r}; expected one of {known}")
