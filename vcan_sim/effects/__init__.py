"""The effects: physics that a nominal robot leaves out, used by the simulator and the diagnosis alike.

To add one, write its file and add its line to `EFFECTS`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.vcan_sim.effects.bump import BumpEvents
from omnimate.vcan_sim.effects.castor_kick import CastorKick
from omnimate.vcan_sim.effects.clock_drift import ClockDrift
from omnimate.vcan_sim.effects.count_loss import CountLoss
from omnimate.vcan_sim.effects.floor_slope import FloorSlope
from omnimate.vcan_sim.effects.gear_backlash import GearBacklash
from omnimate.vcan_sim.effects.gear_harmonic import GearHarmonic
from omnimate.vcan_sim.effects.joint_backlash import JointBacklash
from omnimate.vcan_sim.effects.joint_bias import JointBias
from omnimate.vcan_sim.effects.joint_eccentricity import JointEccentricity
from omnimate.vcan_sim.effects.latency import Latency
from omnimate.vcan_sim.effects.lateral_slip import LateralSlip
from omnimate.vcan_sim.effects.law import Law
from omnimate.vcan_sim.effects.link_bias import LinkBias
from omnimate.vcan_sim.effects.link_eccentricity import LinkEccentricity
from omnimate.vcan_sim.effects.link_scale import LinkScale
from omnimate.vcan_sim.effects.radius_step import RadiusStep
from omnimate.vcan_sim.effects.radius_vs_speed import RadiusVsSpeed
from omnimate.vcan_sim.effects.reference_offset import ReferenceOffset
from omnimate.vcan_sim.effects.slip_patch import SlipPatch
from omnimate.vcan_sim.effects.traction_slip import TractionSlip
from omnimate.vcan_sim.effects.turn_scrub import TurnScrub
from omnimate.vcan_sim.effects.wheel_diameter import WheelDiameter
from omnimate.vcan_sim.effects.wheel_eccentricity import WheelEccentricity
from omnimate.vcan_sim.effects.wheel_misalignment import WheelMisalignment
from omnimate.vcan_sim.effects.wheelbase import Wheelbase
from omnimate.vcan_sim.errors import SimulationError

if TYPE_CHECKING:
    from omnimate.vcan_sim.effects.effect import Effect

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
    ReferenceOffset,
    Law,
)


def effect_named(name: str) -> type[Effect]:
    """Return the kind of effect of a name.

    Raises:
        SimulationError: There is no effect of this name.
    """
    for kind in EFFECTS:
        if kind.name == name:
            return kind
    known = ", ".join(sorted(kind.name for kind in EFFECTS))
    raise SimulationError(f"effect {name!r}; expected one of {known}")
