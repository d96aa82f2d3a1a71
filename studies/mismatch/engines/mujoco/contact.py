"""Faults where a MuJoCo robot meets the floor: soft tyres, oil, a tilted floor, castors that swivel."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from studies.mismatch.engines.mujoco.labels import label
from studies.mismatch.engines.mujoco.model import HOLD
from studies.mismatch.engines.mujoco.setting import FaultyRobot, pull, with_truck, with_tyre, yielding
from studies.mismatch.engines.true_motion import creep, downhill, kicks, lost_in, rolling_ratios

if TYPE_CHECKING:
    from studies.mismatch.engines.mujoco.drive import Scene
    from studies.mismatch.engines.mujoco.setting import Setting
    from studies.mismatch.engines.true_motion import Drive


# The share of the rolled distance, in both halves of a drive, from which creep looks like a smaller wheel.
CREEPING = 3e-4


def tyre_loses_air(at: Setting) -> FaultyRobot:
    """Return a robot whose tyre goes soft at one moment: its wheel then rolls on a smaller radius."""
    wheel, time = at.wheel(), float(at.healthy.time[-1] * at.rng.uniform(0.35, 0.65))
    softness = at.rng.uniform(0.035, 0.055)

    def hook(scene: Scene, now: float) -> None:
        if now >= time:
            scene.model.pair_solref[scene.pair(wheel), 0] = softness

    return FaultyRobot(at.robot, lambda drive: [_step(at, drive, wheel, time)], (hook,))


def payload_moves(at: Setting) -> FaultyRobot:
    """Return a robot with a payload that slides across a truck with one soft tyre."""
    truck, side = at.truck(), str(at.rng.choice(["left", "right"]))
    wheel, time = f"{truck}.{side}", float(at.healthy.time[-1] * at.rng.uniform(0.35, 0.65))
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
    wheel, mid = at.wheel(), float(at.healthy.time[-1] * at.rng.uniform(0.3, 0.6))
    span = (mid, mid + at.rng.uniform(4, 8))
    side, force = 1 if wheel.endswith("left") else -1, at.rng.uniform(10, 25)
    robot = at.robot

    def hook(scene: Scene, now: float) -> None:
        inside = span[0] <= now < span[1]
        pair = scene.pair(wheel)
        scene.model.pair_solimp[pair, :2] = 0.6 if inside else (0.95, 0.99)
        scene.model.pair_solreffriction[pair, 1] = -100.0 if inside else -HOLD / robot.timestep
        pull(scene, wheel[0], force if inside else 0.0, side)

    def labels_of(drive: Drive) -> list[dict[str, Any]]:
        rolled, lost = lost_in(drive, at.nominal, wheel, span)
        values = {"fraction": lost / rolled if rolled else None}
        interval = [[span[0] + at.start, span[1] + at.start]]
        others = (("bump", wheel), ("unknown", wheel), ("unknown", wheel[0]))
        return [label("slip_patch", wheel, values, others, interval)]

    return FaultyRobot(robot, labels_of, (hook,))


def spongy_tyres(at: Setting) -> FaultyRobot:
    """Return a robot whose tyres of one truck yield to every force: the truck creeps outwards in bends."""
    truck, tau = at.truck(), at.rng.uniform(0.001, 0.004)
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
    """Return the robot on a tilted floor; its tyres are of the kind that yields (`corpus.PREPARED`)."""
    tilt, direction = at.rng.uniform(0.03, 0.06), at.rng.uniform(-np.pi, np.pi)
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
