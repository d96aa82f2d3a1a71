"""The worlds whose drives `tracking` judges: recordings of two trucks, and their true or measured poses.

The worlds of `studies/mismatch` share no code with the estimator, and `made` is of the project's own
simulator. Drives are kept in a folder, so that they are made a single time.
"""

from __future__ import annotations

import json
import math
import shutil
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from omnimate.effects.effect import Effect
from omnimate.effects.floor_slope import FloorSlope
from omnimate.effects.lateral_slip import LateralSlip
from omnimate.effects.law import Law
from omnimate.effects.radius_step import RadiusStep
from omnimate.effects.traction_slip import TractionSlip
from omnimate.effects.wheel_eccentricity import WheelEccentricity
from omnimate.effects.wheel_misalignment import WheelMisalignment
from omnimate.files.recordings.folder import load_recording
from omnimate.motion.paths import rounded_rectangle
from omnimate.motion.runner import Runner
from omnimate.motion.stepping import step
from omnimate.vcan_sim.biases import linkage_biases
from omnimate.vcan_sim.floor import Floor, bumps_under
from omnimate.vcan_sim.onboard import odometry_of, update_odometry
from omnimate.vcan_sim.plant import Plant
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.truth import Truth, with_errors
from omnimate.vehicle.recording import Poses, Recording
from studies.mismatch.engines.scene import Case, scene
from studies.mismatch.engines.vocabulary import VOCABULARY
from studies.mismatch.engines.writing import Measuring, write

Drives = Iterator[tuple[str, Recording]]

EXACT = Measuring((1e-6, 1e-6, 1e-6), 0.05, both=False)
SEED = 4  # of the worlds that were in view when the constants were chosen
NO_SENSE = {"clock_drift"}  # of the poses, which judge here
DRIVES = ("eights", "slalom", "squares")
ROBOT = reference_vehicle()
PROGRAM = rounded_rectangle(6.0, 3.25, ["ccw", "cw"])  # O 3
JITTER = math.radians(0.3)  # of joints that scatter
# Pushes of 10 mm to the side within 50 mm of the way, in m/m over the way of a truck.
PUSHES = (5.0, 12.0, 20.0, 27.0, 33.0)
STRIKE = 0.05  # [m]


class World(NamedTuple):
    """A world whose drives are written into a folder."""

    # function that returns the number and the content of each case, in order
    cases: Callable[[], Iterable[tuple[int, Any]]]
    # function of folder, seed, number and content that writes a case and returns its label
    write: Callable[[Path, int, int, Any], dict[str, Any]]
    inside: str = "1"  # where the recording is in a case's folder


def drives_of(world: str, folder: Path, seed: int = SEED) -> Drives:
    """Yield name and recording of each drive of two trucks of a world, which the folder keeps.

    A world is `made`, `common`, a name of `WORLDS`, or a folder of recordings with `labels.json`.
    """
    if world in SIMULATED:
        yield from simulated(SIMULATED[world](), seed)
    elif world in WORLDS:
        yield from _written(WORLDS[world], folder / f"{world}-{seed}", seed)
    else:
        yield from recorded(Path(world))


def _written(world: World, folder: Path, seed: int) -> Drives:
    for number, content in world.cases():
        at = folder / f"{number:02d}"
        if not at.exists():
            unfinished = at.with_name(at.name + ".unfinished")
            shutil.rmtree(unfinished, ignore_errors=True)
            label = world.write(unfinished, seed, number, content)
            (unfinished / "label.json").write_text(json.dumps(label), encoding="utf-8")
            unfinished.rename(at)
        recording = load_recording(at / world.inside)
        if recording.vehicle.linkage is not None:
            yield _name(json.loads((at / "label.json").read_text(encoding="utf-8"))), recording


def recorded(folder: Path) -> Drives:
    """Yield the recordings in a folder with `labels.json`, such as `../shared/data/contact`."""
    for key, label in json.loads((folder / "labels.json").read_text(encoding="utf-8")).items():
        recording = load_recording(folder / key / label["recordings"][0])
        if (
            recording.vehicle.linkage is not None
            and recording.poses is not None
            and len(recording.poses.of("a").time) > 1
        ):
            yield label.get("what") or label.get("drive") or _name(label), recording


def _name(label: dict[str, Any]) -> str:
    effects = " and ".join(f"{effect['effect']} {effect['component']}" for effect in label.get("effects", ()))
    return label.get("name") or effects or "healthy"


# What is concealed in each case of the engine: nothing in three, and each effect of its vocabulary.
SINGLE = tuple(((name, own.components[0]),) for name, own in VOCABULARY.items() if name not in NO_SENSE)
CONCEALED: tuple[tuple[tuple[str, str], ...], ...] = ((),) * 3 + SINGLE


def _write_engine(at: Path, seed: int, number: int, effects: tuple[tuple[str, str], ...]) -> dict[str, Any]:
    case = Case("single" if effects else "null", effects, DRIVES[number % 3], "mocap")
    setting = scene(case, seed * 1000 + number)
    write(at, setting.robot, setting.driven(setting.faults, setting.chance), EXACT, 0.0, setting.chance)
    return {"name": " ".join(effects[0]) if effects else f"healthy {number + 1}"}


def _mujoco_cases() -> Iterable[tuple[int, Any]]:
    """Return each fault of the contact physics."""
    from studies.mismatch.engines.mujoco.cases import FAULTS

    return enumerate(FAULTS)


def _write_mujoco(at: Path, seed: int, number: int, fault: str) -> dict[str, Any]:
    from studies.mismatch.engines.mujoco.cases import make

    exact = replace(EXACT, period=0.03, both=True)
    return {**make(at, seed * 1000 + number, 0, exact, fault=fault), "name": fault}


def _write_drawn(engine: str, at: Path, seed: int, number: int, _content: None) -> dict[str, Any]:
    """Write a case that depends on seed and number alone."""
    label: dict[str, Any] = import_module(f"studies.mismatch.engines.{engine}.cases").make(
        at, seed, number, EXACT
    )
    return label


WORLDS = {
    "engine": World(lambda: enumerate(CONCEALED), _write_engine, "."),
    "mujoco": World(_mujoco_cases, _write_mujoco),
    # of PyBullet the linked pairs
    "bullet": World(lambda: ((number, None) for number in range(2, 62, 5)), partial(_write_drawn, "bullet")),
    "wide": World(lambda: ((number, None) for number in range(24)), partial(_write_drawn, "wide")),
}


def simulated(truths: dict[str, Truth], seed: int) -> Drives:
    """Yield cases of the project's own simulator; floor and encoders of each scatter as usual."""
    for number, (what, truth) in enumerate(truths.items()):
        recording = _drive(replace(truth, seed=seed + number))
        yield what, _jittered(recording, seed) if what == "joint noise 0.3 degrees" else recording


def _common_errors() -> dict[str, Truth]:
    """Return errors that both trucks have alike, and a wheel that is far out of round."""
    pairs = [bump for wheel in ("a.right", "b.right") for bump in bumps_under(wheel, 10, 1.0, 15.0)]
    alternating = bumps_under("a.left", 10, 1.0, 15.0) + bumps_under("b.right", 10, 1.7, 15.7)
    right_larger = with_errors(ROBOT, {}, {"a": 1.003, "b": 1.003})
    plain = Truth(ROBOT, floor=Floor())
    slipping = LateralSlip("a", 0.02), LateralSlip("b", 0.02)
    return {
        "right wheels +0.3 %, bumps": Truth(right_larger, floor=Floor(bumps=alternating)),
        "right wheels over bumps at once": replace(plain, floor=Floor(bumps=tuple(pairs))),
        "lateral slip of both 20 ms": replace(plain, effects=slipping),
        "eccentric wheel 0.8 mm": replace(plain, effects=(WheelEccentricity("b.left", 8e-4, 0.3),)),
    }


def _truths() -> dict[str, Truth]:
    """Return a robot each with a single thing wrong."""
    inside = bumps_under("a.left", 20, 1.0, 16.0, height=0.009)
    both = bumps_under("a.left", 10, 1.0, 15.0) + bumps_under("b.right", 10, 1.0, 15.0)
    plain = Truth(ROBOT, floor=Floor())

    def sizes(base_a: float = 1.0, base_b: float = 1.0, ratio_a: float = 1.0, ratio_b: float = 1.0) -> Truth:
        return Truth(with_errors(ROBOT, {"a": base_a, "b": base_b}, {"a": ratio_a, "b": ratio_b}))

    def acting(*effects: Effect) -> Truth:
        return replace(plain, effects=effects)

    return {
        "healthy": plain,
        "diameter a +0.3 %": sizes(ratio_a=1.003),
        "diameter b +1 %": sizes(ratio_b=1.01),
        "diameters a and b +-0.3 %": sizes(ratio_a=1.003, ratio_b=1.0 / 1.003),
        "wheelbase a -1 %": sizes(0.99),
        "wheelbases off by 3 %": sizes(1.03, 0.97),
        "as data sheets: U Fig. 11": sizes(336.17 / 340.0, 340.0 / 336.17, 1.00084, 1.0 / 1.00084),
        "bumps inside a": replace(plain, floor=Floor(bumps=inside)),
        "bumps a and b": replace(plain, floor=Floor(bumps=both)),
        "joint a 0.5 degrees": acting(*linkage_biases(joint_a=math.radians(0.5))),
        "joint b 0.5 degrees": acting(*linkage_biases(joint_b=math.radians(0.5))),
        "link 5 mm": acting(*linkage_biases(link=0.005)),
        "joint noise 0.3 degrees": replace(sizes(ratio_a=1.002), floor=Floor(bumps=inside)),
        "axle b turned 0.3 degrees": acting(WheelMisalignment("b", math.radians(0.3))),
        "eccentric wheel 0.5 mm": acting(WheelEccentricity("a.left", 5e-4, 0.3)),
        "puncture": acting(RadiusStep("b.left", 0.995, 60.0)),
        "floor sloping": acting(FloorSlope("a", 0.004, 0.7), FloorSlope("b", 0.004, 0.7)),
        "lateral slip": acting(LateralSlip("a", 0.05), LateralSlip("b", 0.02)),
        "traction slip": acting(TractionSlip("a", 0.1)),
        "sideways pushes of 10 mm": acting(_pushes()),
    }


SIMULATED = {"made": _truths, "common": _common_errors}


def _pushes() -> Law:
    """Return pushes of truck a to the left and to the right in turn, each of 10 mm."""
    knots, ordinates = [0.0], [0.0]
    for number, place in enumerate(PUSHES):
        strength = (-1.0) ** number * 0.01 / STRIKE
        knots += [place - 1e-3, place, place + STRIKE, place + STRIKE + 1e-3]
        ordinates += [0.0, strength, strength, 0.0]
    return Law("a", "creep", over="way", knots=tuple(knots), ordinates=tuple(ordinates))


def _drive(truth: Truth) -> Recording:
    """Return the recording of the program, driven from odometry alone, with the true poses of truck a."""
    plant, runner, odometry = Plant(truth, ROBOT), Runner(PROGRAM, ROBOT), odometry_of(ROBOT)[0]
    command, period = np.zeros(4), ROBOT.bus.sync_period
    counts, poses = [], []
    lap = None
    while not runner.done:
        counts.append(plant.state["counts"][0].copy())
        poses.append(plant.pose("a"))
        pose, link = update_odometry(odometry, counts[-1])
        step(runner.rows, runner.settings, runner.state, pose, link, command)
        plant.advance(command, period)
        if runner.lap != lap:
            lap = runner.lap
            plant.begin_lap(lap)
    time = period * np.arange(len(counts), dtype=np.float64)
    table = np.array(counts)
    judge = Poses(time, np.full(len(time), "a"), np.array(poses), np.full((len(time), 3), 1e-6))
    return Recording(ROBOT, time, table, np.ones(table.shape, np.bool_), poses=judge, source="simulation")


def _jittered(recording: Recording, seed: int) -> Recording:
    """Return a recording whose joints scatter from sample to sample."""
    counts = recording.counts.copy()
    for number, channel in enumerate(ROBOT.channels):
        if channel.startswith("joint"):
            jitter = np.random.default_rng([seed, number]).normal(size=len(counts)) * JITTER
            counts[:, number] += np.rint(jitter / ROBOT.encoder(channel).scale).astype(np.int64)
    return replace(recording, counts=counts)
