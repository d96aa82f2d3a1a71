"""The path of a signal through a robot with effects: the stages of `signal_path`, and effects between them.

Effects see blocks of one step here, and in a diagnosis the whole of a recording: the same code.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from vcan_sim.aged_poses import AgedPoses
from vcan_sim.effects.block import LINKAGE, Block, wheel_number
from vcan_sim.effects.effect import STAGES, stage_of
from vcan_sim.signal_path import disturb, glide, move, settle, turn_wheels

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from vcan_sim.effects.effect import Effect, Stage
    from vehicle.compiled import Record
    from vehicle.parameters import VehicleParameters
    from vehicle.se2 import Array

PAUSE = 1.0  # [s] without SYNC that is more than a bus that is late


class AlteredPath:
    """What the effects of one robot remember, and how a step goes with them.

    Attributes:
        time: at the end of the last step [s].
    """

    def __init__(
        self,
        vehicle: VehicleParameters,
        constants: Record,
        effects: Sequence[Effect],
        start_time: float,
        clock: Callable[[], float] | None = None,
    ) -> None:
        """Begin at rest.

        Args:
            vehicle: nominal; its wheels' size makes the speeds that effects see.
            constants: of the true robot.
            effects: at one stage they act in this order.
            start_time: [s].
            clock: that `time` catches up with [s] when it has been left behind; none by default.
        """
        self.time = start_time
        self._clock = clock
        self._own = constants[0]
        self._trucks = len(vehicle.trucks)
        self._effects = {stage: [one for one in effects if stage_of(one) == stage] for stage in STAGES}
        self._states: dict[Stage, list[Any]] = {stage: [None] * len(self._effects[stage]) for stage in STAGES}
        wheels = 2 * self._trucks
        self._radius = np.array([0.5 * vehicle.wheel_diameter(wheel) for wheel in vehicle.wheels])
        self._zero = self._own["offset"][:wheels] / self._own["scale"][:wheels]
        self._rest = 0.0 if vehicle.linkage is None else vehicle.linkage.length
        self._counted = sorted({wheel_number(one.component) for one in self._effects["encoder"]})
        self._read = sorted({LINKAGE.index(one.component) for one in self._effects["reading"]})
        self._poses = AgedPoses(self._effects["poses"], start_time)

    def first(self, state: Record, period: float) -> None:
        """Let effects act on what is read before the first step; those that remember begin after it."""
        if self._read:
            block = self._block(state, np.zeros(2 * self._trucks), period)
            self._show(state, block, [None] * len(self._effects["reading"]))
        self._poses.note(self.time, state[0]["pose"])

    def advance(self, state: Record, obstacles: Record, command: Array, period: float) -> None:
        """Advance the robot by one period [s] with the commanded wheel speeds [rad/s]."""
        own, constants = state[0], self._own
        before = own["speed"][: 2 * self._trucks].copy()
        turn_wheels(constants, own, command, period)
        self._pass(period)
        block = self._act("travel", self._block(state, before, period))
        own["travel"][: 2 * self._trucks] = block.travel[0]
        disturb(constants, own, obstacles)
        if self._counted:
            self._count(state, block)
        if self._effects["body"]:
            self._drift(state, block)
        else:
            move(constants, own)
        settle(constants, own)
        if self._read:
            seen = replace(block, reading=self._reading(state))
            self._states["reading"] = self._show(state, seen, self._states["reading"])
        self._poses.note(self.time, state[0]["pose"])

    def pose(self, truck: int) -> Array:
        """Return the pose of a truck, `(3,)`, as it is told now: as it was some time ago."""
        return self._poses.seen(truck)

    def _pass(self, period: float) -> None:
        """Let time pass; where nobody has sent SYNC for a while, what was left out too."""
        self.time += period
        if self._clock is not None and (now := self._clock()) > self.time + PAUSE:
            self.time = now

    def _act(self, stage: Stage, block: Block) -> Block:
        states = self._states[stage]
        for number, effect in enumerate(self._effects[stage]):
            block, states[number] = effect.act(block, states[number])
        return block

    def _block(self, state: Record, speed_before: Array, period: float) -> Block:
        """Return a block of the step that the wheels have just turned."""
        own, wheels = state[0], 2 * self._trucks
        speed = own["speed"][:wheels]
        return Block(
            time=np.array([self.time]),
            period=np.array([period]),
            angle=(self._zero + own["angle"][:wheels])[None],
            turned=own["turned"][None, :wheels].copy(),
            speed=(self._radius * speed)[None],
            acceleration=(self._radius * (speed - speed_before) / period)[None],
            wheelbase=self._own["wheelbase"][: self._trucks],
            heading=own["pose"][None, : self._trucks, 2].copy(),
            travel=own["travel"][None, :wheels].copy(),
            twist=np.zeros((1, self._trucks, 3)),
            reading=self._reading(state),
            rest=self._rest,
        )

    def _reading(self, state: Record) -> Array:
        """Return what joints [rad] and link [m] read without effects, `(1, 3)`."""
        if self._trucks == 1:
            return np.zeros((1, 0))
        own, constants = state[0], self._own
        joints = own["joint"] + constants["joint_bias"]
        return np.array([[joints[0], joints[1], own["length"] - constants["link_zero"] + self._rest]])

    def _count(self, state: Record, block: Block) -> None:
        """Count what arrives of the wheels' turns."""
        counted = self._act("encoder", block)
        own, constants = state[0], self._own
        for wheel in self._counted:
            missing = block.angle[0, wheel] - counted.angle[0, wheel]
            turned = own["angle"][wheel] - missing
            own["counts"][wheel] = math.floor(constants["offset"][wheel] + constants["scale"][wheel] * turned)

    def _drift(self, state: Record, block: Block) -> None:
        """Move the trucks along what effects make of the arcs of their wheels."""
        own = state[0]
        arcs = replace(block, travel=own["travel"][None, : 2 * self._trucks].copy()).rolled()
        heading = arcs.heading + 0.5 * arcs.twist[:, :, 2]
        glide(self._own, own, self._act("body", replace(arcs, heading=heading)).twist[0])

    def _show(self, state: Record, block: Block, states: Sequence[Any]) -> list[Any]:
        """Quantise what effects make of the linkage's readings; return what they remember."""
        true, shown, after = block.reading[0], block, []
        for effect, before in zip(self._effects["reading"], states, strict=True):
            shown, remembered = effect.act(shown, before)
            after.append(remembered)
        own, constants = state[0], self._own
        counted = *(own["joint"] + constants["joint_bias"]), own["length"] - constants["link_zero"]
        for channel in self._read:
            value = counted[channel] + (shown.reading[0, channel] - true[channel])
            offset, scale = constants["offset"][4 + channel], constants["scale"][4 + channel]
            own["counts"][4 + channel] = math.floor(offset + scale * value + 0.5)
        return after
