"""The effects: physics that a nominal robot leaves out, used by the simulator and the diagnosis alike.

To add one, write its file and add its line to `EFFECTS`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.effects.bump import BumpEvents
from omnimate.effects.castor_kick import CastorKick
from omnimate.effects.clock_drift import ClockDrift
from omnimate.effects.count_loss import CountLoss
from omnimate.effects.errors import EffectError
from omnimate.effects.floor_slope import FloorSlope
from omnimate.effects.gear_backlash import GearBacklash
from omnimate.effects.gear_harmonic import GearHarmonic
from omnimate.effects.joint_backlash import JointBacklash
from omnimate.effects.joint_bias import JointBias
from omnimate.effects.joint_eccentricity import JointEccentricity
from omnimate.effects.latency import Latency
from omnimate.effects.lateral_slip import LateralSlip
from omnimate.effects.law import Law
from omnimate.effects.link_bias import LinkBias
from omnimate.effects.link_eccentricity import LinkEccentricity
from omnimate.effects.link_scale import LinkScale
from omnimate.effects.radius_step import RadiusStep
from omnimate.effects.radius_vs_speed import RadiusVsSpeed
from omnimate.effects.reference_offset import ReferenceOffset
from omnimate.effects.slip_patch import SlipPatch
from omnimate.effects.traction_slip import TractionSlip
from omnimate.effects.turn_scrub import TurnScrub
from omnimate.effects.wheel_diameter import WheelDiameter
from omnimate.effects.wheel_eccentricity import WheelEccentricity
from omnimate.effects.wheel_misalignment import WheelMisalignment
from omnimate.effects.wheelbase import Wheelbase

if TYPE_CHECKING:
    from omnimate.effects.effect import Effect, Scan

EFFECTS: list[type[Effect]] = [
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
]


# In the order of a calibration's report.
CALIBRATED = (Wheelbase, WheelDiameter)


def effects_scanned_by(scan: Scan, component: str) -> list[type[Effect]]:
    """Return the kinds of effects on a component that one kind of scan proposes."""
    return [kind for kind in EFFECTS if kind.scan == scan and component in kind.components]


def effect_named(name: str) -> type[Effect]:
    """Return the kind of effect of a name.

    Raises:
        EffectError: There is no effect of this name.
    """
    for kind in EFFECTS:
        if kind.name == name:
            return kind
    known = ", ".join(sorted(kind.name for kind in EFFECTS))
    raise EffectError(f"effect {name!r}; expected one of {known}")
