"""Square drives of a robot whose actual parameters are known."""

from collections.abc import Callable, Sequence

import numpy as np
import pytest

from omnimate.vehicle.arcs import arc, integrate
from omnimate.vehicle.parameters import Bus, Encoder, Truck, VehicleParameters
from omnimate.vehicle.recording import Lap, Poses, Recording, Run
from omnimate.vehicle.se2 import Array, wrap

PERIOD = 0.1  # [s]
REST, LEG, CORNER = 20, 100, 25  # samples

DriveSquares = Callable[..., Recording]


def encoder(channel: str, node: int) -> Encoder:
    return Encoder(channel, node, 0x180 + node, 0, 32, signed=True, sign=1, counts_per_turn=4_000_000.0)  # type: ignore[arg-type]  # the two wheels


def wheel_steps(truck: Truck, side: float, direction: str) -> Array:
    """Rest, four legs each with its corner, and rest again, as travel `(N, 2)` of the wheels [m]."""
    sign = -1.0 if direction == "cw" else 1.0
    leg = np.full((LEG, 2), side / LEG)
    corner = np.full((CORNER, 2), sign * np.pi / 4 * truck.wheelbase / CORNER) * [-1.0, 1.0]
    rest = np.zeros((REST, 2))
    return np.vstack([rest, *[leg, corner] * 4, rest])


@pytest.fixture
def drive_squares() -> DriveSquares:
    """Return a function that drives squares open loop and records them with a fix in every rest."""

    def drive(
        believed: Truck,
        actual: Truck,
        directions: Sequence[str] = ("cw", "ccw"),
        side: float = 4.0,
        start: tuple[float, float, float] = (1.0, -2.0, 0.7),
    ) -> Recording:
        believed_diameters = np.array([believed.wheel_diameter_left, believed.wheel_diameter_right])
        actual_diameters = np.array([actual.wheel_diameter_left, actual.wheel_diameter_right])
        steps = [wheel_steps(believed, side, direction) for direction in directions]
        travel = np.vstack([np.zeros((1, 2)), *steps])
        true = np.diff(np.cumsum(travel, axis=0), axis=0) * actual_diameters / believed_diameters
        poses = integrate(arc(true[:, 0], true[:, 1], actual.wheelbase), start)
        counts = np.rint(np.cumsum(travel, axis=0) / (np.pi * believed_diameters) * 4e6).astype(np.int64)
        time = 100.0 + PERIOD * np.arange(len(counts))
        length = len(steps[0])
        rests = np.array([length * lap for lap in range(len(directions) + 1)])
        laps = tuple(
            Lap(direction, time[length * lap + REST], time[length * (lap + 1) - REST])  # type: ignore[arg-type]  # cw, ccw
            for lap, direction in enumerate(directions)
        )
        fixes = poses[rests].copy()
        fixes[:, 2] = wrap(fixes[:, 2])
        vehicle = VehicleParameters(
            "test", {"a": believed}, None, Bus(500_000, PERIOD), (encoder("a.left", 1), encoder("a.right", 2))
        )
        return Recording(
            vehicle,
            time,
            counts,
            np.ones(counts.shape, bool),
            Poses(time[rests], np.full(len(rests), "a"), fixes, np.full((len(rests), 3), 0.002)),
            Run("umbmark", side, laps),
            source="squares",
        )

    return drive
