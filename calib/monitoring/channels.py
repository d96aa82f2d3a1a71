"""Checks of recordings before a calibration: frozen encoders, and an uncorrected E_s."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.advice import Advice
from omnimate.calib.errors import CalibrationError
from omnimate.calib.scale import scale_from_straights
from omnimate.vehicle.odometry import truck_travel, wheels_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.vehicle.parameters import Channel, TruckName
    from omnimate.vehicle.recording import Recording

_FROZEN_JOINT_TURN = 1.0  # [rad] turn of the truck after which an unchanged joint is frozen (assumption)
_FROZEN_WHEEL_TRAVEL = (
    0.5  # [m] travel of the other wheel after which an unchanged wheel is frozen (assumption)
)
_FROZEN_LINK_TRAVEL = 5.0  # [m] travel of the truck after which an unchanged link is frozen (assumption)


def advise_on_recordings(recordings: Sequence[Recording], truck: TruckName) -> tuple[Advice, ...]:
    """Return advice on problems of recordings that do not depend on their laps."""
    frozen = [advice for recording in recordings for advice in frozen_linkage(recording)]
    return (*frozen, *_scale(recordings, truck))


def check_frozen(recording: Recording) -> None:
    """Raise an error if a wheel or a channel of the linkage is frozen throughout a recording.

    Raises:
        CalibrationError: A channel is frozen. A frozen wheel is reported before channels of the linkage that
            may only seem frozen because of it.
    """
    for advice in frozen_wheels(recording) or frozen_linkage(recording):
        raise CalibrationError(recording.source, str(advice).removeprefix(f"{recording.source}: "))


def frozen_wheels(recording: Recording) -> tuple[Advice, ...]:
    """Return an error for each wheel that shows one count throughout while the other of its truck rolls."""
    advice = []
    for truck in recording.vehicle.trucks:
        travels = [float(np.abs(np.diff(wheel)).sum()) for wheel in truck_travel(recording, truck)[:2]]
        for wheel, travel, other in zip(wheels_of(truck), travels, reversed(travels), strict=True):
            if travel == 0.0 and other > _FROZEN_WHEEL_TRAVEL:
                what = f"{recording.source}: wheel {wheel} is frozen: not one count while the other one rolls"
                do = "check its encoder, and node, cob_id and start_bit in vehicle.toml, and record anew"
                advice.append(Advice("error", f"{what} {other:.1f} m", do))
    return tuple(advice)


def frozen_linkage(recording: Recording) -> tuple[Advice, ...]:
    """Return an error for each channel of the linkage that shows one count from beginning to end."""
    advice = []
    trucks: tuple[tuple[Channel, TruckName], ...] = (("joint_a", "a"), ("joint_b", "b"), ("link", "a"))
    for channel, truck in trucks:
        if channel not in recording.vehicle.channels or np.ptp(recording.channel_counts(channel)) != 0:
            continue
        left, right, _ = truck_travel(recording, truck)
        turned = float(np.ptp(right - left)) / recording.vehicle.trucks[truck].wheelbase
        travel = float(np.abs(np.diff(0.5 * (left + right))).sum())
        if (travel > _FROZEN_LINK_TRAVEL) if channel == "link" else (turned > _FROZEN_JOINT_TURN):
            what = f"{recording.source}: {channel} is frozen: {travel:.0f} m of driving, and not one count"
            do = "check its encoder, its cable and its cob_id, and record anew; IPEC cannot work without it"
            advice.append(Advice("error", what, do))
    return tuple(advice)


def _scale(recordings: Sequence[Recording], truck: TruckName) -> tuple[Advice, ...]:
    """Return a warning if straights between fixes show an uncorrected E_s."""
    try:
        scale = scale_from_straights(recordings, truck)
    except CalibrationError:
        return ()
    if not scale.is_significant:
        return ()
    what = f"{scale.straights} straights between fixes are {scale.e_s:.4f} times as long as calculated"
    do = f"E_s is left in; add --tape {10.0 * scale.e_s:.4f} 10, which scales wheels and wheelbase"
    return (Advice("warning", what, do),)
