"""What happens to a MuJoCo robot that has no name among the effects: pushes, a jammed slider, a dragged load."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from proof.mujoco_labels import label
from proof.mujoco_robot import WHEELS
from proof.mujoco_setting import Fault, pull, yielding

if TYPE_CHECKING:
    from proof.mujoco_drive import Scene
    from proof.mujoco_setting import Setting


def pushed(at: Setting) -> Fault:
    """Someone pushes a truck aside, harder than its tyres hold, for a moment, twice."""
    truck, length = at.truck(), 0.2
    times = [float(at.healthy.time[-1] * share) for share in at.rng.uniform(0.25, 0.45, 1)] + [
        float(at.healthy.time[-1] * share) for share in at.rng.uniform(0.6, 0.85, 1)
    ]
    force = at.sign() * (1.15 * 9.81 * (at.robot.trucks[truck].mass + 2.5))

    def hook(scene: Scene, now: float) -> None:
        body = scene.data.body(truck)
        active = any(time <= now < time + length for time in times)
        body.xfrc_applied[:3] = force * body.xmat.reshape(3, 3)[:, 1] if active else 0

    return Fault(
        at.robot, lambda _: [_unknown(at, truck, [(t, t + length) for t in times])], (hook,), kind="unknown"
    )


def stuck_slider(at: Setting) -> Fault:
    """The linkage's slider is jammed for a while: the trucks push and drag each other."""
    first = float(at.healthy.time[-1] * at.rng.uniform(0.3, 0.5))
    last = first + float(at.healthy.time[-1] * 0.25)

    def hook(scene: Scene, now: float) -> None:
        dof = scene.model.joint("link").dofadr[0]
        scene.model.dof_damping[dof] = 1e5 if first <= now < last else at.robot.damper

    return Fault(at.robot, lambda _: [_unknown(at, "link", [(first, last)])], (hook,), kind="unknown")


def dragging(at: Setting) -> Fault:
    """Truck b drags a cable that has caught on one side, under tyres that give way, and loses it again."""
    first = float(at.healthy.time[-1] * at.rng.uniform(0.3, 0.6))
    span, side, force = (first, first + 6.0), at.sign(), at.rng.uniform(30, 60)

    def hook(scene: Scene, now: float) -> None:
        scene.data.body("b").xfrc_applied[:] = 0
        if span[0] <= now < span[1]:
            pull(scene, "b", force, side)

    return Fault(
        yielding(at.robot, "b", 0.004), lambda _: [_unknown(at, "b", [span])], (hook,), kind="unknown"
    )


def _unknown(at: Setting, component: str, spans: list[tuple[float, float]]) -> dict[str, Any]:
    intervals = [[first + at.start, last + at.start] for first, last in spans]
    parts = list(WHEELS) if component == "link" else [foot for foot in WHEELS if foot[0] == component]
    others = [("slip_patch", wheel) for wheel in parts] + [("bump", wheel) for wheel in parts]
    others += [("lateral_slip", truck) for truck in ("ab" if component == "link" else component)]
    others += [("unknown", part) for part in (*parts, *("ab" if component == "link" else ()))]
    return label("unknown", component, {}, tuple(others), intervals)
