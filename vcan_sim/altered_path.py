"""The signal path of a robot with effects: at each stage the nominal physics of the plant, then the effects.

The stages and their order are those of `effects.stages`; the last one are the poses as a measuring system
reports them, of its reference point and with latency or clock drift (`AgedPoses`). Effects get blocks of one
step here, and blocks of a whole recording in a diagnosis, by the same code.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimate.effects.ageing import AgedSamples
from omnimate.effects.block import LINKAGE, Block, wheel_number
from omnimate.effects.effect import TRUCK
from omnimate.effects.reference_offset import ReferenceOffset
from omnimate.effects.stages import by_stage
from omnimate.vcan_sim.signal_path import disturb, glide, move, settle, turn_wheels

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from omnimate.effects.effect import Effect, Stage
    from omnimate.vehicle.compiled import Record
    from omnimate.vehicle.parameters import VehicleParameters
    from omnimate.vehicle.se2 import Array

PAUSE = 1.0  # [s] without SYNC from which `time` is set to the clock (assumption)


class AgedPoses:
    """The true poses of all trucks, from the oldest that may still be reported to the latest.

    Args:
        effects: Effects on the measured poses.
        start_time: Time at the start of the drive [s].
    """

    def __init__(self, effects: Iterable[Effect], start_time: float) -> None:
        effects = tuple(effects)
        self._effects = [effect for effect in effects if isinstance(effect, AgedSamples)]
        self._offsets = [effect for effect in effects if isinstance(effect, ReferenceOffset)]
        self._start = start_time
        self._past: deque[tuple[float, Array]] = deque()

    def add(self, time: float, poses: Array) -> None:
        """Add the true poses `(T, 3)` at a time [s], and remove those too old to be reported."""
        self._past.append((time, poses.copy()))
        oldest = time - self._age(time) if self._effects else time
        while len(self._past) > 2 and self._past[1][0] <= oldest:
            self._past.popleft()

    def reported(self, truck: int) -> Array:
        """Return the pose `(3,)` of a truck's reference point that is reported at the time added last."""
        pose = self._delayed(truck)
        for effect in self._offsets:
            if TRUCK.index(effect.component) == truck:
                pose = effect.measured(pose)
        return pose

    def _delayed(self, truck: int) -> Array:
        """Return the delayed pose `(3,)` of a truck."""
        now, poses = self._past[-1]
        if not self._effects:
            return np.array(poses[truck])
        time = np.array([time for time, _ in self._past])
        values = np.stack([poses[truck] for _, poses in self._past])
        age = self._age(now)
        if age < 0.0 and len(time) > 1:  # extrapolated along the last step
            return np.asarray(values[-1] - age * (values[-1] - values[-2]) / (time[-1] - time[-2]))
        return np.array([np.interp(now - age, time, axis) for axis in values.T])

    def _age(self, now: float) -> float:
        return sum(float(effect.age(np.array([now]), self._start)[0]) for effect in self._effects)


class AlteredPath:
    """The step of a robot with effects, with the states of the effects, until `time` [s]."""

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
            vehicle: Nominal vehicle; its wheel radii give the wheel speeds [m/s] in the blocks of effects.
            constants: Constants of the true robot.
            effects: Effects that act; at one stage they act in this order.
            start_time: Time at the start [s].
            clock: Clock to which `time` is set after a `PAUSE` without SYNC [s]; none by default.
        """
        self.time = start_time
        self._clock = clock
        self._constants = constants[0]
        self._trucks = len(vehicle.trucks)
        self._effects = by_stage(effects)
        self._states: dict[Stage, list[Any]] = {
            stage: [None] * len(acting) for stage, acting in self._effects.items()
        }
        self._stage_steps: dict[Stage, Callable[[Record, Record, Block], Block]] = {
            "encoder": self._count,
            "travel": self._travel,
            "body": self._move,
            "reading": self._read,
            "poses": self._add_poses,
        }
        wheels = 2 * self._trucks
        self._radius = np.array([0.5 * vehicle.wheel_diameter(wheel) for wheel in vehicle.wheels])
        self._zero = self._constants["offset"][:wheels] / self._constants["scale"][:wheels]
        self._rest = 0.0 if vehicle.linkage is None else vehicle.linkage.length
        self._counted = sorted({wheel_number(effect.component) for effect in self._effects["encoder"]})
        self._channels = sorted({LINKAGE.index(effect.component) for effect in self._effects["reading"]})
        self._poses = AgedPoses(self._effects["poses"], start_time)

    def apply_to_first_readings(self, state: Record, period: float) -> None:
        """Apply effects to the readings before the first step, without changing the states of the effects."""
        if self._channels:
            block = self._block(state, np.zeros(2 * self._trucks), period)
            self._quantise_readings(state, block, [None] * len(self._effects["reading"]))
        self._poses.add(self.time, state[0]["pose"])

    def advance(self, state: Record, obstacles: Record, command: Array, period: float) -> None:
        """Advance the robot by one period [s] with the commanded wheel speeds [rad/s]."""
        before = state[0]["speed"][: 2 * self._trucks].copy()
        turn_wheels(self._constants, state[0], command, period)
        self._advance_time(period)
        block = self._block(state, before, period)
        for stage in self._effects:
            block = self._stage_steps[stage](state, obstacles, block)

    def pose(self, truck: int) -> Array:
        """Return the pose `(3,)` of a truck that is reported now: with latency, that of an earlier time."""
        return self._poses.reported(truck)

    def _advance_time(self, period: float) -> None:
        """Advance the time by a period [s]; after a pause without SYNC, by the whole pause."""
        self.time += period
        if self._clock is not None and (now := self._clock()) > self.time + PAUSE:
            self.time = now

    def _act(self, stage: Stage, block: Block) -> Block:
        states = self._states[stage]
        for number, effect in enumerate(self._effects[stage]):
            block, states[number] = effect.act(block, states[number])
        return block

    def _block(self, state: Record, speed_before: Array, period: float) -> Block:
        """Return a block of one step, after the wheels have turned and before the trucks move."""
        robot, wheels = state[0], 2 * self._trucks
        speed, travel = robot["speed"][:wheels], robot["travel"][:wheels]
        wheelbase = self._constants["wheelbase"][: self._trucks]
        pose = robot["pose"][: self._trucks]
        heading = pose[:, 2] + 0.5 * (travel[1::2] - travel[0::2]) / wheelbase
        ahead = np.stack([np.cos(heading), np.sin(heading)], axis=-1)
        place = pose[:, :2] + 0.25 * (travel[0::2] + travel[1::2])[:, None] * ahead
        return Block(
            time=np.array([self.time]),
            period=np.array([period]),
            angle=(self._zero + robot["angle"][:wheels])[None],
            turned=robot["turned"][None, :wheels].copy(),
            speed=(self._radius * speed)[None],
            acceleration=(self._radius * (speed - speed_before) / period)[None],
            wheelbase=wheelbase,
            heading=heading[None],
            place=place[None],
            travel=travel[None].copy(),
            twist=np.zeros((1, self._trucks, 3)),
            reading=self._reading(state),
            rest=self._rest,
        )

    def _reading(self, state: Record) -> Array:
        """Return the readings of joints [rad] and link [m], `(1, 3)`, with biases, before effects act."""
        if self._trucks == 1:
            return np.zeros((1, 0))
        joints, length = self._measured(state)
        return np.array([[joints[0], joints[1], length + self._rest]])

    def _measured(self, state: Record) -> tuple[Array, float]:
        """Return the joints' angles `(2,)` [rad] and the link's length beyond its zero [m]."""
        robot, constants = state[0], self._constants
        return robot["joint"] + constants["joint_bias"], float(robot["length"] - constants["link_zero"])

    # The stages

    def _count(self, state: Record, _obstacles: Record, block: Block) -> Block:
        """Count the wheels' turns that reach the encoders; the wheels themselves are unchanged."""
        if not self._counted:
            return block
        counted = self._act("encoder", block)
        robot, constants = state[0], self._constants
        for wheel in self._counted:
            missing = block.angle[0, wheel] - counted.angle[0, wheel]
            turned = robot["angle"][wheel] - missing
            count = constants["offset"][wheel] + constants["scale"][wheel] * turned
            robot["counts"][wheel] = math.floor(count)
        return block

    def _travel(self, state: Record, obstacles: Record, block: Block) -> Block:
        """Compute the travel over the ground, with the floor's roughness and bumps."""
        block = self._act("travel", block)
        state[0]["travel"][: 2 * self._trucks] = block.travel[0]
        disturb(self._constants, state[0], obstacles)
        return block

    def _move(self, state: Record, _obstacles: Record, block: Block) -> Block:
        """Move the trucks along the arcs of their wheels' travel, changed by effects."""
        robot = state[0]
        if not self._effects["body"]:
            move(self._constants, robot)
            return block
        arcs = replace(block, travel=robot["travel"][None, : 2 * self._trucks].copy()).rolled()
        heading = robot["pose"][None, : self._trucks, 2] + 0.5 * arcs.twist[:, :, 2]
        glide(self._constants, robot, self._act("body", replace(arcs, heading=heading)).twist[0])
        return block

    def _read(self, state: Record, _obstacles: Record, block: Block) -> Block:
        """Set the linkage from the trucks, and read it."""
        settle(self._constants, state[0])
        if self._channels:
            read = replace(block, reading=self._reading(state))
            self._states["reading"] = self._quantise_readings(state, read, self._states["reading"])
        return block

    def _add_poses(self, state: Record, _obstacles: Record, block: Block) -> Block:
        """Add the poses that are measured from outside."""
        self._poses.add(self.time, state[0]["pose"])
        return block

    def _quantise_readings(self, state: Record, block: Block, states: Sequence[Any]) -> list[Any]:
        """Set the counts of the linkage from its readings with effects; return the effects' states."""
        true, changed, after = block.reading[0], block, []
        for effect, before in zip(self._effects["reading"], states, strict=True):
            changed, next_state = effect.act(changed, before)
            after.append(next_state)
        constants, (joints, length) = self._constants, self._measured(state)
        measured = (*joints, length)
        for channel in self._channels:
            value = measured[channel] + (changed.reading[0, channel] - true[channel])
            offset, scale = constants["offset"][4 + channel], constants["scale"][4 + channel]
            state[0]["counts"][4 + channel] = math.floor(offset + scale * value + 0.5)
        return after
