"""Recordings of the MuJoCo robot with faults built into it, and labels that tell what was done.

python -m proof.mujoco_corpus OUT [--count N] [--quick] [--seed N]
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from proof import mujoco_contact, mujoco_forces, mujoco_geometry, mujoco_sensors
from proof.mujoco_calibrate import above_noise, calibrate, residuals
from proof.mujoco_control import Nominal
from proof.mujoco_drive import drive
from proof.mujoco_floor import Floor
from proof.mujoco_paths import Pace, eight, rounded, shuttle, square
from proof.mujoco_recording import random_encoders, readings, write_recording
from proof.mujoco_robot import WHEELS, random_robot
from proof.mujoco_setting import Setting, yielding

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from proof.mujoco_drive import Drive
    from proof.mujoco_paths import Program
    from proof.mujoco_robot import Robot
    from proof.mujoco_setting import Fault, Values

FAULTS: dict[str, Callable[[Setting], Fault]] = {
    "wheel_diameter": mujoco_geometry.wheel_diameter,
    "bump": mujoco_geometry.bump,
    "healthy": mujoco_geometry.healthy,
    "wheel_eccentricity": mujoco_geometry.wheel_eccentricity,
    "wheelbase": mujoco_geometry.wheelbase,
    "pushed": mujoco_forces.pushed,
    "wheel_misalignment": mujoco_geometry.wheel_misalignment,
    "joint_bias": mujoco_sensors.joint_bias,
    "tyre_loses_air": mujoco_contact.tyre_loses_air,
    "two_sizes": mujoco_geometry.two_sizes,
    "floor_slope": mujoco_contact.floor_slope,
    "wedged_slider": mujoco_forces.wedged_slider,
    "spongy_tyres": mujoco_contact.spongy_tyres,
    "slippery": mujoco_contact.slippery,
    "healthy 2": mujoco_geometry.healthy,
    "castor_kick": mujoco_contact.castor_kick,
    "joint_eccentricity": mujoco_sensors.joint_eccentricity,
    "link_bias": mujoco_sensors.link_bias,
    "payload_moves": mujoco_contact.payload_moves,
    "dragging": mujoco_forces.dragging,
    "round_and_cables": mujoco_geometry.round_and_cables,
    "hardly": mujoco_geometry.hardly,
    "healthy 3": mujoco_geometry.healthy,
}
PREPARED = {
    "floor_slope": 0.0015,
    "dragging": 0.0015,
    "castor_kick": 0.0015,
    "wedged_slider": 0.0015,
    "slippery": None,
}
CABLES = {"bump", "round_and_cables"}  # driven slowly: at 0.4 m/s the shock makes the other wheel slip too
OUTSIDE = {"floor_slope"}  # what takes both trucks alike shows in measured poses only
RESOLVED = np.array([1e-4] * 6 + [1e-4, 1e-4, 1e-4])  # what nobody measures better [m, rad]
POSES = ("none", "sonar", "mocap")  # in turn
CLEAR = 5.0  # standard deviations below which a recording may well not tell


def corpus(count: int) -> list[str]:
    """Return the names of `count` cases: every fault in turn."""
    names = list(FAULTS)
    return [names[i % len(names)] for i in range(count)]


def write(folder: Path | str, cases: Iterable[str], seed: int) -> dict[str, Any]:
    """Write recordings and their `labels.json`, and return the labels.

    Args:
        folder: made where it is absent.
        cases: names out of FAULTS.
        seed: of everything that is drawn; a case depends on it and on its own place alone.
    """
    folder, labels = Path(folder), {}
    folder.mkdir(parents=True, exist_ok=True)
    for number, name in enumerate(cases):
        poses = POSES[number % 3] if name not in OUTSIDE else POSES[1 + number % 2]
        key, entry = _case(folder, name, poses, np.random.default_rng([seed, number]))
        labels[key] = entry
        (folder / "labels.json").write_text(json.dumps(labels, indent=1))
    return labels


def nominal_by_geometry(robot: Robot) -> Nominal:
    """Return a robot's measures by ruler."""
    radii = np.array([robot.tyres[wheel].radius for wheel in WHEELS])
    return Nominal(radii, np.array([robot.trucks[truck].track for truck in "ab"]), robot.link)


def calibrated(robot: Robot, program: Program) -> Nominal:
    """Return the values that a healthy robot's own calibration drive on a flat floor gives."""
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


def _entry(fault: Fault, run: Drive, sigmas: float, poses: str) -> dict[str, Any]:
    """Return a case's label; what cannot be seen may be answered so."""
    effects = fault.tell(run)
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
    """Return what is true of tyres that give way, beside the fault: no finding of it is wrong."""
    effects = ("lateral_slip", "traction_slip") if creep else ()
    return [{"effect": effect, "component": truck} for effect in effects for truck in "ab"]


def main() -> None:
    """Write a corpus where the command line says."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--count", type=int, default=66)
    parser.add_argument("--quick", action="store_true", help="six cases")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    labels = write(given.out, corpus(6 if given.quick else given.count), given.seed)
    driven, spent = (
        sum(entry[key] for entry in labels.values()) for key in ("seconds_of_driving", "seconds_to_make")
    )
    print(f"{len(labels)} recordings, {driven / 60:.1f} min of driving, made in {spent:.0f} s")


if __name__ == "__main__":
    main()
