"""Faults of the MuJoCo robot, by what is built into it, and their labels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from studies.mismatch.engines.mujoco.drive import Hook, Scene
from studies.mismatch.engines.mujoco.model import HOLD, Cable, Robot
from studies.mismatch.engines.true_motion import (
    Draws,
    Drive,
    creep,
    crossings,
    downhill,
    kicks,
    lost,
    path_of,
    rolling_ratios,
)
from studies.mismatch.engines.vocabulary import WHEELS, label
from studies.mismatch.engines.writing import Device

Values = dict[str, NDArray[np.float64]]
Labels = Callable[[Drive], list[dict[str, Any]]]


def _unchanged(values: Values) -> Values:
    return values


@dataclass(frozen=True, slots=True)
class Setting(Draws):
    """What a fault is built into."""

    robot: Robot  # the healthy robot
    devices: tuple[Device, ...]  # encoders on the bus

    def zero_angle(self, wheel: str) -> float:
        """Return the angle [rad] that a wheel's counter shows where the simulated angle is zero."""
        device = next(candidate for candidate in self.devices if candidate.channel == wheel)
        return device.sign * device.zero * device.unit / device.resolution


@dataclass(frozen=True, slots=True)
class FaultyRobot:
    robot: Robot  # the robot as it is built
    labels_of: Labels  # function that returns the labels of a drive of this robot
    hooks: tuple[Hook, ...] = ()  # functions that change the world during the drive
    sense: Callable[[Values], Values] = _unchanged  # function that changes what the sensors read
    kind: str = "single"  # kind of the case: null, single, multi, unknown or insufficient


def with_tyre(robot: Robot, wheel: str, **changes: float) -> Robot:
    return replace(robot, tyres=robot.tyres | {wheel: replace(robot.tyres[wheel], **changes)})


def with_truck(robot: Robot, truck: str, **changes: float) -> Robot:
    return replace(robot, trucks=robot.trucks | {truck: replace(robot.trucks[truck], **changes)})


def pull(scene: Scene, truck: str, force: float, side: float) -> None:
    """Apply a force [N] against a truck's motion at its left (+1), right (-1) or middle (0)."""
    body = scene.data.body(truck)
    ahead = body.xmat.reshape(3, 3)[:, 0]
    speed = float(scene.data.joint(f"{truck}.left").qvel[0] + scene.data.joint(f"{truck}.right").qvel[0])
    push = -force * np.tanh(speed * 0.2)
    body.xfrc_applied[:3] = push * ahead
    body.xfrc_applied[3:] = (0, 0, -push * side * 0.2)


def yielding(robot: Robot, creep: float | None, trucks: str = "ab") -> Robot:
    """Return a robot with tyres that yield to forces, the more the longer the time constant `creep` [s].

    With None the tyres hold, and only oil under them (`slippery`) lets them slide.
    """
    for wheel in WHEELS:
        if wheel[0] in trucks and creep is not None:
            robot = with_tyre(robot, wheel, creep=creep, impedance=0.6)
    return replace(robot, impratio=0.2)


def _labelled(
    robot: Robot, effect: str, component: str, values: dict[str, Any], *others: tuple[str, str]
) -> FaultyRobot:
    """Return a robot with a fault whose size is that which is built in, and others that look like it."""
    return FaultyRobot(robot, lambda _: [label(effect, component, values, others)])


def healthy(at: Setting) -> FaultyRobot:
    """Return the robot without a fault."""
    return FaultyRobot(at.robot, lambda _: [], kind="null")


def wheel_diameter(at: Setting) -> FaultyRobot:
    """Return a robot with a wheel of another diameter."""
    wheel, ratio = at.wheel(), 1 + at.sign() * at.chance.uniform(0.002, 0.008)
    likes = ("count_loss", wheel), ("radius_vs_speed", wheel)  # at one speed they are the same
    robot = with_tyre(at.robot, wheel, radius=at.robot.tyres[wheel].radius * ratio)
    return _labelled(robot, "wheel_diameter", wheel, {"ratio": ratio}, *likes)


def hardly(at: Setting) -> FaultyRobot:
    """Return a robot with a wheel that differs by 3e-5, which no recording can show."""
    wheel, ratio = at.wheel(), 1 + at.sign() * 3e-5
    robot = with_tyre(at.robot, wheel, radius=at.robot.tyres[wheel].radius * ratio)
    return replace(_labelled(robot, "wheel_diameter", wheel, {"ratio": ratio}), kind="insufficient")


def wheel_eccentricity(at: Setting) -> FaultyRobot:
    """Return a robot with a wheel whose axle is off its centre."""
    wheel, amplitude, phase = at.wheel(), at.chance.uniform(3e-4, 1e-3), at.chance.uniform(-np.pi, np.pi)
    robot = with_tyre(at.robot, wheel, eccentricity=amplitude, phase=phase)
    seen = amplitude * nodding(at.robot, wheel) * np.exp(1j * (phase - at.zero_angle(wheel)))
    values = {"amplitude": float(np.abs(seen)), "phase": float(np.angle(seen))}
    return _labelled(robot, "wheel_eccentricity", wheel, values, ("gear_harmonic", wheel))


def nodding(robot: Robot, wheel: str) -> complex:
    """Return the complex factor on an eccentric wheel's wave that comes from the pitching of its truck.

    The wheel lifts its end of the axle, the truck pitches about its castor, and the wheels turn with it.
    """
    return 1 + 0.5j * robot.tyres[wheel].radius / robot.trucks[wheel[0]].castor


def wheelbase(at: Setting) -> FaultyRobot:
    """Return a robot with another track on one truck."""
    truck, ratio = at.truck(), 1 + at.sign() * at.chance.uniform(0.008, 0.03)
    robot = with_truck(at.robot, truck, track=at.robot.trucks[truck].track * ratio)
    return _labelled(robot, "wheelbase", truck, {"ratio": ratio}, ("turn_scrub", truck))


def wheel_misalignment(at: Setting) -> FaultyRobot:
    """Return a robot with an axle that is turned in its truck."""
    truck, angle = at.truck(), at.sign() * at.chance.uniform(0.005, 0.015)
    robot = with_truck(at.robot, truck, toe=angle)
    return _labelled(robot, "wheel_misalignment", truck, {"angle": angle}, ("joint_bias", f"joint_{truck}"))


def bump(at: Setting) -> FaultyRobot:
    """Return a robot that meets cables under one wheel in every lap."""
    wheel, height = at.wheel(), at.chance.uniform(0.005, 0.009)
    robot = replace(
        at.robot, cables=tuple(Cable(wheel, *place, height, 0.3) for place in _places(at, wheel, 4))
    )

    def labels_of(drive: Drive) -> list[dict[str, Any]]:
        spans, lost = crossings(drive, at.nominal, wheel, at.start)
        values = {"times": [first for first, _ in spans], "lost": lost}
        return [label("bump", wheel, values, (("slip_patch", wheel),), spans)]

    return FaultyRobot(robot, labels_of)


def _places(at: Setting, wheel: str, count: int) -> list[tuple[float, float, float]]:
    """Return places on a wheel's path where it rolls steadily [m], and directions across the path [rad]."""
    pose = at.healthy.poses[:, WHEELS.index(wheel) // 2]
    x, y = path_of(at.healthy, at.nominal.tracks, wheel).T
    speed = np.diff(at.healthy.wheels[:, WHEELS.index(wheel)]) * at.nominal.radii[0] / at.healthy.time[1]
    yaw = np.diff(np.unwrap(pose[:, 2])) / at.healthy.time[1]
    rolling = (speed > 0.15) & (np.abs(yaw) < 0.35)
    steady = np.flatnonzero(np.convolve(~rolling, np.ones(121), "same") < 0.5)  # also 0.9 s before and after
    steady = steady if len(steady) > 500 else np.flatnonzero(rolling)
    rows = steady[
        np.linspace(0, len(steady) - 1, count + 2).astype(int)[1:-1] + at.chance.integers(-20, 20, count)
    ]
    return [(float(x[row]), float(y[row]), float(pose[row, 2] + np.pi / 2)) for row in rows]


def two_sizes(at: Setting) -> FaultyRobot:
    """Return a robot with a wheel of another diameter and another track on a truck."""
    return _both(at, wheel_diameter, wheelbase)


def round_and_cables(at: Setting) -> FaultyRobot:
    """Return a robot with an eccentric wheel and cables under a wheel."""
    return _both(at, wheel_eccentricity, bump)


def _both(
    at: Setting, first: Callable[[Setting], FaultyRobot], second: Callable[[Setting], FaultyRobot]
) -> FaultyRobot:
    one = first(at)
    two = second(replace(at, robot=one.robot))
    return FaultyRobot(two.robot, lambda run: [*one.labels_of(run), *two.labels_of(run)], kind="multi")


def joint_bias(at: Setting) -> FaultyRobot:
    """Return a robot with a joint encoder that is mounted at an angle."""
    joint, bias = at.joint(), at.sign() * at.chance.uniform(0.002, 0.008)
    biased = _labelled(at.robot, "joint_bias", joint, {"bias": bias}, ("wheel_misalignment", joint[-1]))
    return replace(biased, sense=lambda values: values | {joint: values[joint] + bias})


def joint_eccentricity(at: Setting) -> FaultyRobot:
    """Return a robot with the disc of a joint encoder off the joint's centre."""
    offset, bearing = at.chance.uniform(0.003, 0.01), at.chance.uniform(-np.pi, np.pi)

    def sense(values: Values) -> Values:
        angle = values["joint_a"]
        seen = np.exp(1j * angle) + offset * np.exp(1j * bearing)
        return values | {"joint_a": angle + np.angle(seen * np.exp(-1j * angle))}

    phase = float(np.angle(np.exp(1j * (np.pi / 2 - bearing))))
    values = {"amplitude": offset, "phase": phase}
    other = "joint_bias", "joint_a"
    return replace(_labelled(at.robot, "joint_eccentricity", "joint_a", values, other), sense=sense)


def link_bias(at: Setting) -> FaultyRobot:
    """Return a robot with a linear encoder that is not mounted where `vehicle.toml` says."""
    bias = at.sign() * at.chance.uniform(0.002, 0.006)
    biased = _labelled(at.robot, "link_bias", "link", {"bias": bias})
    return replace(biased, sense=lambda values: values | {"link": values["link"] + bias})


# The share of the rolled distance, in both halves of a drive, from which creep looks like a smaller wheel.
CREEPING = 3e-4


def tyre_loses_air(at: Setting) -> FaultyRobot:
    """Return a robot whose tyre goes soft at one moment: its wheel then rolls on a smaller radius."""
    wheel, time = at.wheel(), at.moment(0.35, 0.65)
    softness = at.chance.uniform(0.035, 0.055)

    def hook(scene: Scene, now: float) -> None:
        if now >= time:
            scene.model.pair_solref[scene.pair(wheel), 0] = softness

    return FaultyRobot(at.robot, lambda drive: [_step(at, drive, wheel, time)], (hook,))


def payload_moves(at: Setting) -> FaultyRobot:
    """Return a robot with a payload that slides across a truck with one soft tyre."""
    truck, side = at.truck(), str(at.chance.choice(["left", "right"]))
    wheel, time = f"{truck}.{side}", at.moment(0.35, 0.65)
    way = at.sign() * 0.12
    robot = with_truck(with_tyre(at.robot, wheel, softness=0.03), truck, payload=25.0)

    def hook(scene: Scene, now: float) -> None:
        scene.data.actuator(f"{truck}.load").ctrl = np.clip((now - time) * 0.12, -1, 1) * way

    def labels_of(drive: Drive) -> list[dict[str, Any]]:
        ratio = rolling_ratios(drive, at.nominal, wheel, time)[0]
        soft = label("wheel_diameter", wheel, {"ratio": ratio}, (("radius_step", wheel),))
        return [_step(at, drive, wheel, time), soft]

    return FaultyRobot(robot, labels_of, (hook,), kind="multi")


def _step(at: Setting, drive: Drive, wheel: str, time: float) -> dict[str, Any]:
    before, after = rolling_ratios(drive, at.nominal, wheel, time)
    values = {"ratio": after / before, "time": time + at.start}
    until = [time + at.start, float(drive.time[-1] + at.start)]
    return label("radius_step", wheel, values, (("slip_patch", wheel), ("wheel_diameter", wheel)), [until])


def slippery(at: Setting) -> FaultyRobot:
    """Return a robot with oil under one wheel while the truck drags a load on that side: the wheel slips."""
    wheel, mid = at.wheel(), at.moment(0.3, 0.6)
    span = (mid, mid + at.chance.uniform(4, 8))
    side, force = 1 if wheel.endswith("left") else -1, at.chance.uniform(10, 25)
    robot = at.robot

    def hook(scene: Scene, now: float) -> None:
        inside = span[0] <= now < span[1]
        pair = scene.pair(wheel)
        scene.model.pair_solimp[pair, :2] = 0.6 if inside else (0.95, 0.99)
        scene.model.pair_solreffriction[pair, 1] = -100.0 if inside else -HOLD / robot.timestep
        pull(scene, wheel[0], force if inside else 0.0, side)

    def labels_of(drive: Drive) -> list[dict[str, Any]]:
        values = {
            "fraction": lost(drive, at.nominal, wheel, (drive.time >= span[0]) & (drive.time < span[1]))
        }
        interval = [[span[0] + at.start, span[1] + at.start]]
        others = (("bump", wheel), ("unknown", wheel), ("unknown", wheel[0]))
        return [label("slip_patch", wheel, values, others, interval)]

    return FaultyRobot(robot, labels_of, (hook,))


def spongy_tyres(at: Setting) -> FaultyRobot:
    """Return a robot whose tyres of one truck yield to every force: the truck creeps outwards in bends."""
    truck, tau = at.truck(), at.chance.uniform(0.001, 0.004)
    robot = yielding(at.robot, tau, truck)

    def labels_of(drive: Drive) -> list[dict[str, Any]]:
        values = {"compliance": float(creep(drive)["ab".index(truck)])}
        others = [("traction_slip", truck), ("wheelbase", truck), ("turn_scrub", truck)]
        for wheel in (f"{truck}.left", f"{truck}.right"):
            ratios = rolling_ratios(drive, at.nominal, wheel, float(drive.time[-1]) / 2.0)
            if all(abs(ratio - 1.0) > CREEPING for ratio in ratios):  # the wheel also creeps forward
                others.append(("wheel_diameter", wheel))
        return [label("lateral_slip", truck, values, tuple(others))]

    return FaultyRobot(robot, labels_of)


def floor_slope(at: Setting) -> FaultyRobot:
    """Return the robot on a tilted floor; its tyres are of the kind that yields (`cases.PREPARED`)."""
    tilt, direction = at.chance.uniform(0.03, 0.06), at.chance.uniform(-np.pi, np.pi)
    robot = replace(at.robot, tilt=(tilt * np.cos(direction), tilt * np.sin(direction)))

    def labels_of(drive: Drive) -> list[dict[str, Any]]:
        values = {"rate": downhill(drive, at.nominal, at.healthy), "direction": direction}
        return [
            label("floor_slope", t, values, (("lateral_slip", t), ("traction_slip", t), ("unknown", t)))
            for t in "ab"
        ]

    return FaultyRobot(robot, labels_of)


def castor_kick(at: Setting) -> FaultyRobot:
    """Return a robot with a trailing castor on a stiff pin and tyres that yield: it yaws at each reversal."""
    truck = at.truck()
    robot = with_truck(at.robot, truck, trail=0.04)
    others = (("unknown", truck), ("traction_slip", truck))

    def labels_of(drive: Drive) -> list[dict[str, Any]]:
        yaw = float(kicks(drive, at.nominal, "ab".index(truck)).mean())
        return [label("castor_kick", truck, {"yaw": yaw}, others)]

    return FaultyRobot(robot, labels_of)


def pushed(at: Setting) -> FaultyRobot:
    """Return a robot with a truck that is pushed aside twice for a moment, harder than its tyres hold."""
    truck, length = at.truck(), 0.2
    times = [at.moment(0.25, 0.45), at.moment(0.6, 0.85)]
    force = at.sign() * (1.15 * 9.81 * (at.robot.trucks[truck].mass + 2.5))

    def hook(scene: Scene, now: float) -> None:
        body = scene.data.body(truck)
        active = any(time <= now < time + length for time in times)
        body.xfrc_applied[:3] = force * body.xmat.reshape(3, 3)[:, 1] if active else 0

    return FaultyRobot(
        at.robot, lambda _: [_unknown(at, truck, [(t, t + length) for t in times])], (hook,), kind="unknown"
    )


def wedged_slider(at: Setting) -> FaultyRobot:
    """Return a robot with a slider that jams for a while: the trucks push or pull each other."""
    first = at.moment(0.3, 0.5)
    last, wedge = first + float(at.healthy.time[-1] * 0.2), at.sign() * 0.02

    def hook(scene: Scene, now: float) -> None:
        joint = scene.model.joint("link")
        inside = first <= now < last
        scene.model.jnt_stiffness[joint.id] = 4e3 if inside else at.robot.spring
        scene.model.qpos_spring[joint.qposadr[0]] = wedge * np.clip(now - first, 0, 1) if inside else 0

    return FaultyRobot(at.robot, lambda _: [_unknown(at, "link", [(first, last)])], (hook,), kind="unknown")


def dragging(at: Setting) -> FaultyRobot:
    """Return a robot with yielding tyres that drags a cable on one side of truck b for a while."""
    first = at.moment(0.3, 0.6)
    span, side, force = (first, first + 6.0), at.sign(), at.chance.uniform(50, 90)

    def hook(scene: Scene, now: float) -> None:
        scene.data.body("b").xfrc_applied[:] = 0
        if span[0] <= now < span[1]:
            pull(scene, "b", force, side)

    return FaultyRobot(at.robot, lambda _: [_unknown(at, "b", [span])], (hook,), kind="unknown")


def _unknown(at: Setting, component: str, spans: list[tuple[float, float]]) -> dict[str, Any]:
    intervals = [[first + at.start, last + at.start] for first, last in spans]
    wheels = list(WHEELS) if component == "link" else [wheel for wheel in WHEELS if wheel[0] == component]
    others = [("slip_patch", wheel) for wheel in wheels] + [("bump", wheel) for wheel in wheels]
    others += [("lateral_slip", truck) for truck in ("ab" if component == "link" else component)]
    others += [("unknown", place) for place in (*wheels, *("ab" if component == "link" else ()))]
    return label("unknown", component, {}, tuple(others), intervals)
