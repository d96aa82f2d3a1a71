"""Faults without a name in the vocabulary: a MuJoCo robot is pushed, its slider jams, it drags a load."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from studies.mismatch.engines.mujoco.labels import label
from studies.mismatch.engines.mujoco.robot import WHEELS
from studies.mismatch.engines.mujoco.setting import FaultyRobot, pull

if TYPE_CHECKING:
    from studies.mismatch.engines.mujoco.drive import Scene
    from studies.mismatch.engines.mujoco.setting import Setting


def pushed(at: Setting) -> FaultyRobot:
    """Return a robot with a truck that is pushed aside twice for a moment, harder than its tyres hold."""
    truck, length = at.truck(), 0.2
    times = [float(at.healthy.time[-1] * share) for share in at.rng.uniform(0.25, 0.45, 1)] + [
        float(at.healthy.time[-1] * share) for share in at.rng.uniform(0.6, 0.85, 1)
    ]
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
    first = float(at.healthy.time[-1] * at.rng.uniform(0.3, 0.5))
    last, wedge = first + float(at.healthy.time[-1] * 0.2), at.sign() * 0.02

    def hook(scene: Scene, now: float) -> None:
        joint = scene.model.joint("link")
        inside = first <= now < last
        scene.model.jnt_stiffness[joint.id] = 4e3 if inside else at.robot.spring
        scene.model.qpos_spring[joint.qposadr[0]] = wedge * np.clip(now - first, 0, 1) if inside else 0

    return FaultyRobot(at.robot, lambda _: [_unknown(at, "link", [(first, last)])], (hook,), kind="unknown")


def dragging(at: Setting) -> FaultyRobot:
    """Return a robot with yielding tyres that drags a cable on one side of truck b for a while."""
    first = float(at.healthy.time[-1] * at.rng.uniform(0.3, 0.6))
    span, side, force = (first, first + 6.0), at.sign(), at.rng.uniform(50, 90)

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
