"""The cases of the MuJoCo robot: faults built into it in turn, and labels that say what was built in."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from studies.mismatch.engines.mujoco import faults
from studies.mismatch.engines.mujoco.control import Pace, Program, eight, rounded, shuttle, square
from studies.mismatch.engines.mujoco.drive import Floor, drive
from studies.mismatch.engines.mujoco.faults import FaultyRobot, Setting, Values, yielding
from studies.mismatch.engines.mujoco.model import Robot, random_robot
from studies.mismatch.engines.true_motion import Drive, Nominal, above_noise, calibrate, residuals
from studies.mismatch.engines.vocabulary import CLEAR, LINKAGE, WHEELS, case_label
from studies.mismatch.engines.writing import Device, Log, Measuring, write
from studies.mismatch.engines.writing import Robot as Described

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
# How poses are measured, in turn: not at all, at the stops, or 33 times a second.
POSES: tuple[Measuring | None, ...] = (
    None,
    Measuring((0.002, 0.002, 0.0052), 0.0, both=True),
    Measuring((0.001, 0.001, 0.00175), 0.03, both=True),
)
GROUPS = (("a.left", "a.right"), ("b.left", "b.right"), ("joint_a", "joint_b"), ("link",))  # in one PDO each
# Counts per turn of wheels and of joints, and per metre of the link.
RESOLUTIONS = (8192, 20000, 40000), (16384, 36000, 65536), (10000, 50000)
READING_NOISE, SYNC_SCATTER = 5e-5, 5e-5  # [rad, m] of the linkage's encoders; [s]


def nominal_by_geometry(robot: Robot) -> Nominal:
    """Return a robot's nominal values from its geometry, as a ruler measures them."""
    radii = np.array([robot.tyres[wheel].radius for wheel in WHEELS])
    return Nominal(radii, np.array([robot.trucks[truck].track for truck in "ab"]), robot.link)


def calibrated(robot: Robot, program: Program) -> Nominal:
    """Return the nominal values that a calibration drive of a healthy robot on a flat floor gives."""
    flat = Floor(np.random.default_rng(0), 0.0)
    return calibrate(drive(robot, flat, program, nominal_by_geometry(robot)), robot.link)


def make(
    folder: Path,
    seed: int,
    number: int,
    measuring: Measuring | None = None,
    *,
    fault: str = "",
    faultless: bool = False,
) -> dict[str, Any]:
    """Write the recording of a case into a folder, and return its label.

    A drive in which the contacts become unstable (FloatingPointError) is none: the case is drawn once more.
    """
    name = "healthy" if faultless else fault or list(FAULTS)[number % len(FAULTS)]
    poses = measuring or POSES[1 + number % 2 if name in POSES_ONLY else number % 3]
    try:
        return _made(folder, np.random.default_rng([seed, number]), name, poses)
    except FloatingPointError:
        return _made(folder, np.random.default_rng([seed, number, 1]), name, poses)


def _made(folder: Path, rng: np.random.Generator, name: str, poses: Measuring | None) -> dict[str, Any]:
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
    described = _described(key, nominal, pace.dt, _encoders(rng))
    built = FAULTS[name](Setting(rng, nominal, before, start, robot, described.devices))
    after = (
        drive(built.robot, floor, program, nominal, built.hooks, weave) if built.kind != "null" else before
    )
    values = built.sense(_readings(after, robot.link))
    write(folder / "1", described, _log(after, values, described, program, start, rng), poses, 0.0, rng)
    sigmas = _sigmas(after, before, values, nominal, robot)
    return {
        **_label(built, after, sigmas),
        "poses": "none" if poses is None else f"{poses.period:g} s",
        "fault": name,
        "acceptable_findings": _tyres(PREPARED.get(name)),
        "seconds_of_driving": round(float(after.time[-1]), 1),
    }


def _encoders(rng: np.random.Generator) -> tuple[Device, ...]:
    """Return a robot's seven encoders, as four nodes with one PDO each."""
    nodes = rng.choice(np.arange(1, 60), 4, replace=False)
    wheel, joint, link = (int(rng.choice(choices)) for choices in RESOLUTIONS)
    bits = int(rng.choice([24, 32]))
    devices = []
    for node, group in zip(nodes.tolist(), GROUPS, strict=True):
        for place, channel in enumerate(group):
            turning = channel in WHEELS
            resolution = wheel if turning else link if channel == "link" else joint
            width = bits if turning else 32
            zero = int(rng.integers(-4000, 4000)) if turning or rng.random() < 0.5 else 0
            place_in_pdo, sign = (place * width, width), int(rng.choice([1, -1]))
            devices.append(Device(channel, node, 0x180 + node, *place_in_pdo, True, sign, resolution, zero))
    return tuple(devices)


def _described(name: str, nominal: Nominal, period: float, devices: tuple[Device, ...]) -> Described:
    """Return the robot as its owner believes it to be, in whole micrometres."""
    tracks, radii = nominal.tracks.round(6).tolist(), (2.0 * nominal.radii).round(7) / 2.0
    return Described(
        name,
        2,
        tuple(tracks),
        tuple(radii.tolist()),
        round(nominal.link, 6),
        round(period, 4),
        devices,
        sync_scatter=SYNC_SCATTER,
    )


def _readings(run: Drive, rest: float) -> Values:
    """Return what perfect sensors read, by channel [rad, m]; the link from its length at rest."""
    return dict(zip((*WHEELS, *LINKAGE), [*run.wheels.T, *(run.linkage - (0.0, 0.0, rest)).T], strict=True))


def _log(
    run: Drive, values: Values, robot: Described, program: Program, start: float, rng: np.random.Generator
) -> Log:
    """Return a drive as it is recorded; encoders count whole steps down."""
    counts = []
    for device in robot.devices:
        noise = rng.normal(0.0, READING_NOISE, len(run.time)) if device.channel in LINKAGE else 0.0
        counts.append(device.counted(values[device.channel] + noise, -0.5))
    time = run.time + start
    laps = [(direction, float(time[first]), float(time[last])) for direction, first, last in program.laps]
    stops = time[[program.laps[0][1] - 10, *(last + 20 for _, _, last in program.laps)]]
    table = np.stack(counts, axis=1)
    return Log(time, table, run.poses, laps, stops.tolist(), program.protocol, program.side)


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
    read = np.stack([values[channel] for channel in LINKAGE], axis=1)
    seen = replace(after, linkage=np.add(read, (0.0, 0.0, robot.link)))
    return above_noise(residuals(seen, nominal), residuals(before, nominal), RESOLVED)


def _label(fault: FaultyRobot, run: Drive, sigmas: float) -> dict[str, Any]:
    """Return what a label says of a fault; where it cannot be seen, an answer may say so."""
    effects = [effect | {"sigmas_above_noise": round(sigmas, 2)} for effect in fault.labels_of(run)]
    return {**case_label(fault.kind, effects, weak=bool(effects) and sigmas < CLEAR), "engine": "mujoco"}


def _tyres(creep: float | None) -> list[dict[str, str]]:
    """Return the effects that yielding tyres have beside the fault; a finding that names one is not wrong."""
    effects = ("lateral_slip", "traction_slip") if creep else ()
    return [{"effect": effect, "component": truck} for effect in effects for truck in "ab"]
