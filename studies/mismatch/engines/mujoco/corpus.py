"""Recordings of the MuJoCo robot with faults built into it, and labels that say what was built in."""

from __future__ import annotations

import json
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from studies.mismatch.engines.mujoco import faults
from studies.mismatch.engines.mujoco.control import Pace, eight, rounded, shuttle, square
from studies.mismatch.engines.mujoco.drive import Floor, drive
from studies.mismatch.engines.mujoco.faults import Setting, yielding
from studies.mismatch.engines.mujoco.model import random_robot
from studies.mismatch.engines.mujoco.recording import random_encoders, readings, write_recording
from studies.mismatch.engines.true_motion import Nominal, above_noise, calibrate, residuals
from studies.mismatch.engines.vocabulary import WHEELS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from studies.mismatch.engines.mujoco.control import Program
    from studies.mismatch.engines.mujoco.faults import FaultyRobot, Values
    from studies.mismatch.engines.mujoco.model import Robot
    from studies.mismatch.engines.true_motion import Drive

FAULTS: dict[str, Callable[[Setting], FaultyRobot]] = {
    "wheel_diameter": faults.wheel_diameter,
    "bump": faults.bump,
    "healthy": faults.healthy,
    "wheel_eccentricity": faults.wheel_eccentricity,
    "wheelbase": faults.wheelbase,
    "pushed": faults.pushed,
    "wheel_misalignment": faults.wheel_misalignment,
    "joint_bias": faults.joint_bias,
    "tyre_loses_air": faults.tyre_loses_air,
    "two_sizes": faults.two_sizes,
    "floor_slope": faults.floor_slope,
    "wedged_slider": faults.wedged_slider,
    "spongy_tyres": faults.spongy_tyres,
    "slippery": faults.slippery,
    "healthy 2": faults.healthy,
    "castor_kick": faults.castor_kick,
    "joint_eccentricity": faults.joint_eccentricity,
    "link_bias": faults.link_bias,
    "payload_moves": faults.payload_moves,
    "dragging": faults.dragging,
    "round_and_cables": faults.round_and_cables,
    "hardly": faults.hardly,
    "healthy 3": faults.healthy,
}
# Time constant of tyres that yield [s], for faults that need them; None for tyres that hold.
PREPARED = {
    "floor_slope": 0.0015,
    "dragging": 0.0015,
    "castor_kick": 0.0015,
    "wedged_slider": 0.0015,
    "slippery": None,
}
CABLES = {"bump", "round_and_cables"}  # driven slowly: at 0.4 m/s the shock makes the other wheel slip too
POSES_ONLY = {"floor_slope"}  # moves both trucks alike, and is visible in measured poses only
RESOLVED = np.array([1e-4] * 6 + [1e-4, 1e-4, 1e-4])  # below the resolution of any sensor [m, rad]
POSES = ("none", "sonar", "mocap")  # in turn
CLEAR = 5.0  # standard deviations below which a recording may not show the fault


def corpus(count: int) -> list[str]:
    """Return the names of `count` cases: every fault in turn."""
    names = list(FAULTS)
    return [names[i % len(names)] for i in range(count)]


def write(folder: Path | str, cases: Iterable[str], seed: int, poses: str | None = None) -> dict[str, Any]:
    """Write recordings and their `labels.json`, and return the labels.

    Args:
        folder: Folder of the corpus; it is made where it is absent.
        cases: Names of faults, keys of FAULTS.
        seed: Seed of all random draws; a case depends on it and on its place in the list alone.
        poses: Kind of absolute poses, as `write_recording` takes it; None for all kinds in turn.
    """
    folder, labels = Path(folder), {}
    folder.mkdir(parents=True, exist_ok=True)
    for number, name in enumerate(cases):
        kind = POSES[number % 3] if name not in POSES_ONLY else POSES[1 + number % 2]
        key, entry = _case(folder, name, poses or kind, np.random.default_rng([seed, number]))
        labels[key] = entry
        (folder / "labels.json").write_text(json.dumps(labels, indent=1))
    return labels


def nominal_by_geometry(robot: Robot) -> Nominal:
    """Return a robot's nominal values from its geometry, as a ruler measures them."""
    radii = np.array([robot.tyres[wheel].radius for wheel in WHEELS])
    return Nominal(radii, np.array([robot.trucks[truck].track for truck in "ab"]), robot.link)


def calibrated(robot: Robot, program: Program) -> Nominal:
    """Return the nominal values that a calibration drive of a healthy robot on a flat floor gives."""
    flat = Floor(np.random.default_rng(0), 0.0)
    return calibrate(drive(robot, flat, program, nominal_by_geometry(robot)), robot.link)


def _case(folder: Path, name: str, poses: str, rng: np.random.Generator) -> tuple[str, dict[str, Any]]:
    began = time.monotonic()
    key = rng.bytes(4).hex()
    robot, floor = random_robot(rng), Floor(rng, rng.uniform(0.003, 0.006))
    if name in PREPARED:
        robot = yielding(robot, PREPARED[name])
    speed = rng.uniform(0.2, 0.27) if name in CABLES else rng.uniform(0.3, 0.42)
    pace = Pace(robot.timestep * 10, speed, rng.uniform(0.8, 1.2))
    program = _program(rng, pace, straight=name == "castor_kick")
    turning = rounded(pace, 1.6, (1, -1)) if program.protocol == "straight" else program.first(2)
    nominal, weave = calibrated(robot, turning), rng.uniform(0.0, 0.3)
    before = drive(robot, floor, program, nominal, weave=weave)
    start = float(1763670000 + rng.integers(0, 10**6)) + 0.005
    at = Setting(rng, robot, before, nominal, random_encoders(rng), start)
    fault = FAULTS[name](at)
    after = (
        drive(fault.robot, floor, program, nominal, fault.hooks, weave) if fault.kind != "null" else before
    )
    values = fault.sense(readings(after, robot.link))
    write_recording(folder / key / "1", after, values, nominal, at.encoders, program, poses, start, rng)
    sigmas = _sigmas(after, before, values, nominal, robot)
    entry = _entry(fault, after, sigmas, poses) | {"fault": name}
    entry["acceptable_findings"] = _tyres(PREPARED.get(name))
    return key, entry | {
        "seconds_of_driving": round(float(after.time[-1]), 1),
        "seconds_to_make": round(time.monotonic() - began, 1),
    }


def _program(rng: np.random.Generator, pace: Pace, *, straight: bool) -> Program:
    """Return a program of 60 to 130 s with four laps or more."""
    turns = (1, -1, 1, -1) if rng.random() < 0.5 else (-1, 1, -1, 1)
    if straight:
        return shuttle(pace, rng.uniform(1.6, 2.2), 6)
    kind = rng.integers(0, 4)
    if kind == 0:
        return eight(pace, rng.uniform(7.0, 9.0), 4)
    if kind == 1:
        return square(pace, float(np.round(rng.uniform(1.4, 1.8), 1)), turns)
    return rounded(pace, rng.uniform(1.7, 2.3), turns)


def _sigmas(after: Drive, before: Drive, values: Values, nominal: Nominal, robot: Robot) -> float:
    seen = replace(
        after,
        joints=np.stack([values["joint_a"], values["joint_b"]], axis=1),
        link=values["link"] + robot.link,
    )
    return above_noise(residuals(seen, nominal), residuals(before, nominal), RESOLVED)


def _entry(fault: FaultyRobot, run: Drive, sigmas: float, poses: str) -> dict[str, Any]:
    """Return a case's label; where the fault cannot be seen, an answer may say so."""
    effects = fault.labels_of(run)
    hidden = bool(effects) and sigmas < CLEAR
    verdict = ["agreement"] if not effects else ["mismatch"]
    if hidden:
        verdict = ["insufficient", "agreement", "mismatch"]
    return {
        "kind": "insufficient" if hidden else fault.kind,
        "verdict": verdict,
        "poses": poses,
        "recordings": ["1"],
        "effects": [effect | {"sigmas_above_noise": round(sigmas, 2)} for effect in effects],
        "engine": "mujoco",
    }


def _tyres(creep: float | None) -> list[dict[str, str]]:
    """Return the effects that yielding tyres have beside the fault; a finding that names one is not wrong."""
    effects = ("lateral_slip", "traction_slip") if creep else ()
    return [{"effect": effect, "component": truck} for effect in effects for truck in "ab"]
