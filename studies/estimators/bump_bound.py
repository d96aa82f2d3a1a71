"""What could be kept of a lap with 20 bumps (O 3) by a filter that is told when a wheel meets a bump.

Peers: plain odometry, IPEC, the filter, and the filter on the same robots and floors without bumps, which is
what a filter could keep that is told how much a wheel loses as well.

Each robot has the errors that a calibration leaves (`studies.papers.robots.LEFT_BEHIND`), drawn again, and
drives one lap of O 3. The informed filter distrusts a wheel from the sample in which it touches the
obstacle until it has left it, and no other wheel.

Usage: python -m studies.estimators.bump_bound [seeds [first seed]]
"""

from __future__ import annotations

import numpy as np

from omnimate.ipec.corrector import correct
from omnimate.ipec.filter.estimate import estimate
from omnimate.ipec.filter.live import NO_MOVES, Filter
from omnimate.ipec.filter.step import finish_step, predict
from omnimate.ipec.readings import ordered_counts
from omnimate.motion.paths import rounded_rectangle
from omnimate.vcan_sim.floor import Bump, bumps_under
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vehicle.parameters import Channel
from omnimate.vehicle.recording import Recording
from omnimate.vehicle.se2 import Array
from studies.benchmark import options
from studies.papers.linkage_numbers import lap_errors
from studies.papers.robots import LEFT_BEHIND, calibrated_truth

ROBOT = reference_vehicle()
HEIGHT = 0.009  # [m] of the cables


def bumps_of(seed: int) -> tuple[Channel, tuple[Bump, ...]]:
    """Return the wheel of truck a that meets bumps, and 20 cables of 9 mm under it."""
    wheel: Channel = "a.left" if seed % 2 else "a.right"
    return wheel, bumps_under(wheel, 20, 1.0, 16.0, height=HEIGHT)


def lap(seed: int, *, bumps: bool) -> Recording:
    """Return a lap of O 3, 18.5 m, with bumps or without."""
    program = rounded_rectangle(6.0, 3.25, ["cw" if seed % 4 < 2 else "ccw"])
    return simulate(ROBOT, calibrated_truth(ROBOT, bumps_of(seed)[1] if bumps else (), seed), program)


def touching(recording: Recording, seed: int) -> tuple[int, Array]:
    """Return the number of the wheel that meets bumps, and whether it touches one in each sample `(N,)`."""
    wheel, bumps = bumps_of(seed)
    radius = 0.5 * recording.vehicle.trucks["a"].wheel_diameter_left
    rolled = radius * np.abs(recording.wheel_angle(wheel) - recording.wheel_angle(wheel)[0])
    places = np.array([bump.after for bump in bumps])
    reach = np.sqrt(2.0 * radius * HEIGHT)
    near = np.abs(rolled[:, None] - places) <= reach
    return ("a.left", "a.right").index(wheel), near.any(axis=1)


def told(recording: Recording, seed: int) -> Array:
    """Return the path of truck a `(N, 3)` by a filter that is told which wheel is on a bump, and when."""
    wheel, near = touching(recording, seed)
    counts, present = ordered_counts(recording)
    filter_ = Filter(recording.vehicle, prior=LEFT_BEHIND)
    filter_.settings["gate"] = np.inf
    begun = filter_.start()
    state, filters = begun.record.copy(), begun.filters.copy()
    path = np.empty((len(counts), 3))
    for sample in range(len(counts)):
        if near[sample]:
            filters["alert"][:, wheel] = 1e-3
        if predict(filter_.settings, state, counts[sample], present[sample]):
            finish_step(filter_.settings, state, filters, NO_MOVES)
        mean = state["mean"][0]
        path[sample] = mean[0], mean[1], mean[2] + mean[3]
    return path


def interval(values: Array) -> str:
    """Return root mean square, its 95 % interval by bootstrap, and the largest."""
    again = np.random.default_rng(0).choice(values, (1000, len(values)))
    low, high = np.percentile(np.sqrt(np.mean(again**2, axis=1)), [2.5, 97.5])
    return f"{np.sqrt(np.mean(values**2)):7.3f} ({low:6.3f} to {high:6.3f}) worst {np.abs(values).max():7.3f}"


def main() -> None:
    given = options(__doc__, {"seeds": 40, "first": 5000})
    count, first = given.seeds, given.first
    errors: dict[str, list[Array]] = {}
    for seed in range(first, first + count):
        bumpy, smooth = lap(seed, bumps=True), lap(seed, bumps=False)
        paths = {
            "plain": (bumpy, correct(bumpy, method="plain").pose_a),
            "IPEC": (bumpy, correct(bumpy).pose_a),
            "filter": (bumpy, estimate(bumpy, prior=LEFT_BEHIND).pose_a),
            "told when": (bumpy, told(bumpy, seed)),
            "no bumps": (smooth, estimate(smooth, prior=LEFT_BEHIND).pose_a),
        }
        for name, (recording, path) in paths.items():
            errors.setdefault(name, []).append(lap_errors(recording, path)[0])
    print(f"O 3, 20 bumps under one wheel of truck a; rms of {count}")
    for name, rows in errors.items():
        x, y, theta = np.array(rows).T
        position, heading = interval(1e3 * np.hypot(x, y)), interval(np.degrees(theta))
        print(f"  {name:<10} position [mm] {position}   heading [degrees] {heading}")


if __name__ == "__main__":
    main()
