"""What may be wrong with a recording that a calibration rests on: encoders that stand still, E_s left in."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from calib.errors import CalibrationError
from calib.guards import Advice
from calib.scale import scale_from_straights
from vehicle.odometry import truck_travel, wheels_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vehicle.parameters import Channel, TruckName
    from vehicle.recording import Recording

_TURN = 1.0  # [rad] after which a joint has moved
_ROLL = 0.5  # [m] after which the other wheel has moved
_WAY = 5.0  # [m] after which a compliant link has moved


def advise_about(recordings: Sequence[Recording], truck: TruckName) -> tuple[Advice, ...]:
    """Return what looks wrong with recordings themselves, whatever their laps say."""
    frozen = [one for recording in recordings for one in frozen_linkage(recording)]
    return (*frozen, *_scale(recordings, truck))


def check_frozen(recording: Recording) -> None:
    """Refuse a recording in which a wheel or a channel of the linkage shows one count throughout.

    Raises:
        CalibrationError: the first such channel; a wheel before what seems to follow from it.
    """
    for one in frozen_wheels(recording) or frozen_linkage(recording):
        raise CalibrationError(recording.source, str(one).removeprefix(f"{recording.source}: "))


def frozen_wheels(recording: Recording) -> tuple[Advice, ...]:
    """Return an error for each wheel that shows one count throughout while the other of its truck rolls."""
    found = []
    for truck in recording.vehicle.trucks:
        ways = [float(np.abs(np.diff(wheel)).sum()) for wheel in truck_travel(recording, truck)[:2]]
        for wheel, way, other in zip(wheels_of(truck), ways, reversed(ways), strict=True):
            if way == 0.0 and other > _ROLL:
                what = f"{recording.source}: wheel {wheel} is frozen: not one count while the other one rolls"
                do = "check its encoder, and node, cob_id and start_bit in vehicle.toml, and record anew"
                found.append(Advice("error", f"{what} {other:.1f} m", do))
    return tuple(found)


def frozen_linkage(recording: Recording) -> tuple[Advice, ...]:
    """Return an error for each channel of the linkage that shows one count from beginning to end."""
    found = []
    trucks: tuple[tuple[Channel, TruckName], ...] = (("joint_a", "a"), ("joint_b", "b"), ("link", "a"))
    for channel, truck in trucks:
        if channel not in recording.vehicle.channels or np.ptp(recording.channel_counts(channel)) != 0:
            continue
        left, right, _ = truck_travel(recording, truck)
        turned = float(np.ptp(right - left)) / recording.vehicle.trucks[truck].wheelbase
        way = float(np.abs(np.diff(0.5 * (left + right))).sum())
        if (way > _WAY) if channel == "link" else (turned > _TURN):
            what = f"{recording.source}: {channel} is frozen: {way:.0f} m of driving, and not one count"
            do = "check its encoder, its cable and its cob_id, and record anew; IPEC cannot work without it"
            found.append(Advice("error", what, do))
    return tuple(found)


def _scale(recordings: Sequence[Recording], truck: TruckName) -> tuple[Advice, ...]:
    """Return a warning where straights between fixes show that E_s was left in; squares alone never do."""
    try:
        scale = scale_from_straights(recordings, truck)
    except CalibrationError:
        return ()
    if not scale.matters:
        return ()
    what = f"{scale.straights} straights between fixes are {scale.e_s:.4f} times as long as calculated"
    do = f"E_s is left in; add --tape {10.0 * scale.e_s:.4f} 10, which scales wheels and wheelbase"
    return (Advice("warning", what, do),)
