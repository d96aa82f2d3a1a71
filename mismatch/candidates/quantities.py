"""What a robot does in a drive, as curves on which an error may depend, with no physics in them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from omnimate.effects.variables import Motion, decaying_sum, recent_direction, recent_mean
from omnimate.mismatch.candidates.terms import moving_channels, turns
from omnimate.mismatch.recording.causal_path import FORGETTING
from omnimate.mismatch.recording.signals import is_dense
from omnimate.mismatch.recording.windows import stated_sigma
from omnimate.vehicle.parameters import JOINTS

if TYPE_CHECKING:
    from collections.abc import Container, Sequence

    from omnimate.mismatch.recording.signals import Signals
    from omnimate.vehicle.se2 import Array

KNOTS = 5  # of a curve over a quantity, evenly spaced: a drive's large excursions decide, not what jitters
FOOTPRINT = 0.05  # [m] contact length of a wheel: a robot that strays less meets the same floor
# The recent past, in steps of a factor of three, and oscillators that are a resonance's width apart
RECENT_TIMES = (3.0, 10.0, 30.0, 100.0)  # [s] over which a speed is forgotten: from a manoeuvre to a drive
RECENT_ANGLES = (0.1, 0.3, 1.0)  # [rad] of turning over which its direction is forgotten
FREQUENCIES = 0.4 * 1.25 ** np.arange(8)  # [Hz] 0.4 to 1.9: what readings four times a second show
OSCILLATION = "oscillation of {:.1f} Hz after {}"
DAMPING = 0.1  # of an oscillator, over the critical one
RARE = 0.005  # share of the samples beyond either end of a curve: too few to identify it there

Curves = dict[str, list["Array"]]


def shared_quantities(signals: Sequence[Signals]) -> list[Curves]:
    """Return of each recording the curves over the quantities that vary in all of them.

    Where a channel hardly moves, or the robot hardly turns, that is noise.
    """
    moving = moving_channels(signals) | ({"turning"} if turns(signals) else set())
    curves = [_quantities(recording, moving) for recording in signals]
    return [
        {name: of_recording[name] for name in curves[0] if all(name in other for other in curves)}
        for of_recording in curves
    ]


def _quantities(signals: Signals, moving: Container[str]) -> Curves:
    """Return curves `(N - 1,)` of order one over each quantity on which an error may depend.

    They are taken from the wheels, and from the linkage's angles: what readings round off must not stand on
    both sides of a regression on readings. The second truck's wheels follow the linkage, so that their speeds
    and accelerations answer what disturbs it: only what the first truck does shows a cause (closed-loop
    identification: Forssell & Ljung, Automatica 1999). `moving` are the channels that move, and "turning"
    where the robot turns.
    """
    block, linked = signals.smooth_block, bool(signals.reading.shape[1])
    lead = Motion(block, "a")
    phase, distance = np.linspace(0.0, np.pi, len(block)), lead.way
    along = np.pi * (distance - distance[0]) / max(float(np.ptp(distance)), 1e-9)
    curves = {
        "time": waves(phase, (1, 2, 3))[::2],
        "distance": waves(along, (1, 2, 3))[::2],
        "SYNC period": bends(block.period),
    }
    for number, wheel in enumerate(signals.wheels):
        curves[f"angle of {wheel}"] = waves(block.angle[:, number], (1, 2, 3))
        if number < 2:
            curves[f"speed of {wheel}"] = bends(block.speed[:, number])
            curves[f"acceleration of {wheel}"] = bends(block.acceleration[:, number])
            curves[f"past acceleration of {wheel}"] = bends(Motion(block, wheel).past_acceleration)
    speed = np.abs(lead.speeds[:, 0])
    curves["recent speed"] = [standard(recent_mean(block.period, speed, length)) for length in RECENT_TIMES]
    curves |= oscillations("accelerations", block.period, lead.mean(block.acceleration))
    noise = noise_of_path(signals)
    for number, truck in enumerate(signals.trucks):
        position, heading = block.place[:, number], block.heading[:, number]
        x, y = (
            standard(beyond(values, max(least, FOOTPRINT)))
            for values, least in zip(position.T, noise[:2], strict=True)
        )
        curves[f"place of {truck}"] = [x, y, x * y, x**2, y**2]
        if "turning" not in moving:
            continue
        facing = [beyond(wave, noise[2]) for wave in waves(heading, (1,))]
        twice = [beyond(wave, 2.0 * noise[2]) for wave in waves(heading, (2,))]
        curves[f"heading of {truck}"] = [*facing, *twice]
        curves[f"place and heading of {truck}"] = [
            *facing,
            *(place * direction for place in (x, y) for direction in facing),
        ]
    if "turning" in moving:
        turning = lead.turn_rates[:, 0]
        curves["turn rate"] = bends(turning)
        curves["yaw acceleration"] = bends(lead.yaw_accelerations[:, 0])
        curves["turning since a reversal"] = reversals(turning * block.period)
        curves |= oscillations("turns", block.period, lead.yaw_accelerations[:, 0])
        curves["lateral acceleration"] = bends(turning * lead.speeds[:, 0])
    for number, joint in enumerate(JOINTS if linked else ()):
        if joint in moving:
            curves[f"angle of {joint}"] = waves(block.reading[:, number], (1, 2))
            curves[f"turns of {joint}"] = bends(block.reading[:, number])
    if "link" in moving:
        curves["link length"] = bends(block.reading[:, 2])
    if linked and "turning" in moving:
        curves["yaw acceleration of link"] = bends(lead.link_yaw_acceleration)
    return {quantity: curve for quantity, curve in curves.items() if curve}


def noise_of_path(signals: Signals) -> Array:
    """Return by how much x, y [m] and heading [rad] must vary along the path for a curve over them, `(3,)`.

    The path follows the measured poses, whose noise is in it. Of N poses, a curve that varies by s predicts
    the share (noise / s)^2 of each one's own innovation; all of them are less than one where s is sqrt(N)
    times the noise (errors in variables).
    """
    poses = None if signals.poses is None else signals.poses.of("a")
    if poses is None or not len(poses.time):
        return np.zeros(3)
    followed = 1.0  # share of a pose's noise that is in the path
    if is_dense(poses):
        followed -= math.exp(-float(np.median(np.diff(poses.time))) / FORGETTING)
    return np.asarray(followed * math.sqrt(len(poses.time)) * np.median(stated_sigma(poses.sigma), axis=0))


def beyond(curve: Array, noise: float) -> Array:
    """Return a curve; zeros where its standard deviation is not beyond the noise."""
    return curve if float(curve.std()) > noise else np.zeros_like(curve)


def waves(angle: Array, orders: Sequence[int]) -> list[Array]:
    """Return cosines and sines of multiples of an angle."""
    return [wave(order * angle) for order in orders for wave in (np.cos, np.sin)]


def bends(values: Array) -> list[Array]:
    """Return curves that are straight between knots over the range of values; none if they are constant."""
    low, high = np.quantile(values, (RARE, 1.0 - RARE)).tolist()
    knots = np.linspace(low, high, KNOTS)
    if high - low < 1e-9:
        return []
    return [standard(np.interp(values, knots, ordinate)) for ordinate in np.eye(len(knots))[1:]]


def reversals(moves: Array) -> list[Array]:
    """Return the direction in which a robot moved of late, and whether its moves (K,) go on in it.

    That is the state of Dahl's model of friction (1968), which is forgotten over each of `RECENT_ANGLES`.
    None are returned where it hardly ever moves back.
    """
    forward = float(np.maximum(moves, 0.0).sum()) / max(float(np.abs(moves).sum()), 1e-9)
    if not RARE < forward < 1.0 - RARE:
        return []
    direction, states = np.sign(moves), [recent_direction(moves, length) for length in RECENT_ANGLES]
    return [standard(part) for state in states for part in (state, direction * state)]


def oscillations(cause: str, period: Array, acceleration: Array) -> Curves:
    """Return how an oscillator of each frequency answers an acceleration (K,), in phase and out of phase."""
    pushed, curves = (acceleration * period).astype(np.complex128), Curves()
    for frequency in FREQUENCIES:
        pole = 2.0 * np.pi * frequency * (1j - DAMPING)
        answer = decaying_sum(np.exp(pole * period), pushed, 0j)
        curves[OSCILLATION.format(frequency, cause)] = [standard(part) for part in (answer.real, answer.imag)]
    return curves


def standard(values: Array) -> Array:
    """Return values less their mean, in units of their deviation; zeros where they are constant."""
    away = values - values.mean()
    deviation = float(away.std())
    return away / deviation if deviation > 1e-9 else np.zeros_like(away)
