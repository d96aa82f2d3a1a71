"""The return errors of IPEC and of the filter in the papers' drives, over many robots and floors.

Peers: plain odometry on the same drives, and the bound of what the encoders can show.

Each robot has the errors that a calibration leaves, drawn anew (standard deviations: ratio of diameters
2e-4, wheelbase 1e-3, joints 0.01 degrees, link 0.3 mm). The bound is the posterior standard deviation of
the filter that knows these, on a floor without sideways slip: the linearised Cramer-Rao bound.

Usage: python -m studies.estimators.ipec_accuracy [seeds [first seed]]
"""

from __future__ import annotations

import numpy as np

from omnimate.ipec.corrector import Method, correct
from omnimate.ipec.filter.estimate import estimate
from omnimate.ipec.filter.prior import FilterNoise
from omnimate.motion.paths import out_and_back, rounded_rectangle
from omnimate.motion.program import Program
from omnimate.vcan_sim.bumps import Bump, bumps_under
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vehicle.parameters import Channel
from omnimate.vehicle.recording import Recording
from omnimate.vehicle.se2 import Array, between, compose, wrap
from studies.benchmark import options
from studies.papers.robots import LEFT_BEHIND, calibrated_truth

ROBOT = reference_vehicle()
LINK = 1.0  # [m], length of its link
METHODS: dict[str, Method] = {"plain": "plain", "CLAPPER": "clapper", "OmniMate": "omnimate"}


def drive(seed: int, program: Program, bumps: tuple[Bump, ...]) -> Recording:
    return simulate(ROBOT, calibrated_truth(ROBOT, bumps, seed), program)


def under(side: str, count: int, start: float, end: float, *, apart: float) -> tuple[Bump, ...]:
    """Return bumps under both trucks: truck b meets each one a link length later (or, in reverse, before)."""
    wheels: dict[Channel, float] = {f"a.{side}": 0.0, f"b.{side}": apart}  # type: ignore[dict-item]  # a channel
    return tuple(
        bump
        for wheel, later in wheels.items()
        for bump in bumps_under(wheel, count, start + later, end + later)
    )


def straight(seed: int, *, bumps: bool) -> Recording:
    """C 6.1: 18 m out and back in reverse, 20 bumps on the way back."""
    obstacles = under("right", 10, 18.5, 35.5, apart=-LINK) if bumps else ()
    return drive(seed, out_and_back(18.0, 1, speed=0.45, link_length=1.0), obstacles)


def rectangle(seed: int, *, bumps: bool) -> Recording:
    """C 6.2: 7 x 4 m, 10 bumps under the wheels of one side."""
    side = "left" if seed % 2 else "right"
    program = rounded_rectangle(7.0, 4.0, ["cw" if seed % 4 < 2 else "ccw"], tolerance=0.2, speed=0.45)
    return drive(seed, program, under(side, 5, 1.0, 19.0, apart=LINK) if bumps else ())


def lap(seed: int, *, bumps: bool) -> Recording:
    """O 3: 18.5 m, 20 cables of 9 mm under one wheel of the front truck."""
    wheel: Channel = "a.left" if seed % 2 else "a.right"
    program = rounded_rectangle(6.0, 3.25, ["cw" if seed % 4 < 2 else "ccw"])
    return drive(seed, program, bumps_under(wheel, 20, 1.0, 16.0, height=0.009) if bumps else ())


def return_error(recording: Recording, path: Array) -> Array:
    """Return the true minus the estimated last pose of truck a, from the fix before the drive on."""
    fixes = recording.poses.of("a").pose  # type: ignore[union-attr]  # simulations have poses
    error = fixes[-1] - compose(fixes[0], between(path[0], path[-1]))
    return np.array([*error[:2], wrap(error[2])])


def interval(values: Array) -> str:
    """Return root mean square, its 95 % interval by bootstrap, and the largest."""
    chance = np.random.default_rng(0)
    again = chance.choice(values, (1000, len(values)))
    low, high = np.percentile(np.sqrt(np.mean(again**2, axis=1)), [2.5, 97.5])
    return f"{np.sqrt(np.mean(values**2)):7.3f} ({low:6.3f} to {high:6.3f}) worst {np.abs(values).max():7.3f}"


def show(name: str, errors: Array) -> None:
    place, heading = 1e3 * np.hypot(errors[:, 0], errors[:, 1]), np.degrees(errors[:, 2])
    print(f"  {name:<10} position [mm] {interval(place)}   heading [degrees] {interval(heading)}")


def single_drives(seeds: range) -> None:
    for make in (straight, rectangle, lap):
        for bumps in (False, True):
            what = (make.__doc__ or "").splitlines()[0].split(",")[0]
            print(f"{what}, {'with' if bumps else 'without'} bumps; rms of {len(seeds)}")
            errors: dict[str, list[Array]] = {}
            squares, bound = [], []
            for seed in seeds:
                recording = make(seed, bumps=bumps)
                for name, method in METHODS.items():
                    path = correct(recording, method=method).pose_a
                    errors.setdefault(name, []).append(return_error(recording, path))
                filtered = estimate(recording, prior=LEFT_BEHIND)
                errors.setdefault("filter", []).append(return_error(recording, filtered.pose_a))
                squares.append((errors["filter"][-1] / filtered.sigma_a[-1]) ** 2)
                noise = FilterNoise(sideways=0.0)
                bound.append(estimate(recording, noise=noise, prior=LEFT_BEHIND).sigma_a[-1])
            for name, rows in errors.items():
                show(name, np.array(rows))
            show("bound", np.array(bound))
            print(f"  NEES per axis {np.mean(squares, axis=0).round(2)} (1 if consistent)")


def main() -> None:
    given = options(__doc__, {"seeds": 40, "first": 0})
    single_drives(range(given.first, given.first + given.seeds))


if __name__ == "__main__":
    main()
