"""A CiA 402 drive that turns a wheel by target velocity (60FFh), with its ramps and its watchdogs."""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING

from omnimate.vcan_sim.nodes.device import Device, NmtState
from omnimate.vcan_sim.nodes.objects import refuse_unless

if TYPE_CHECKING:
    from collections.abc import Callable

    from omnimate.vcan_sim.nodes.encoder import Sensor
    from omnimate.vcan_sim.nodes.objects import Objects

_HALT = 0x0100  # bit 8 of the controlword
_PROFILE_VELOCITY, _CYCLIC_VELOCITY = 3, 9  # modes of operation, 6060h
_SHUTDOWN, _SWITCH_ON, _ENABLE = 0x06, 0x07, 0x0F
_VOLTAGE, _NO_QUICK_STOP, _FAULT_RESET = 0x02, 0x04, 0x80


class PowerState(IntEnum):
    """The states, by the bits of the statusword (mask 6Fh) that show them."""

    SWITCH_ON_DISABLED = 0x40
    READY_TO_SWITCH_ON = 0x21
    SWITCHED_ON = 0x23
    OPERATION_ENABLED = 0x27
    QUICK_STOP_ACTIVE = 0x07
    FAULT_REACTION_ACTIVE = 0x0F
    FAULT = 0x08


_FAULTY = {PowerState.FAULT, PowerState.FAULT_REACTION_ACTIVE}
_POWERED = {PowerState.SWITCHED_ON, PowerState.OPERATION_ENABLED}


def next_state(state: PowerState, controlword: int, previous: int) -> PowerState:
    """Return the state after a controlword; `previous` is the one before, for the edge of fault reset."""
    if state in _FAULTY:
        edge = controlword & ~previous & _FAULT_RESET
        return PowerState.SWITCH_ON_DISABLED if edge and state is PowerState.FAULT else state
    if not controlword & _VOLTAGE:
        return PowerState.SWITCH_ON_DISABLED
    if not controlword & _NO_QUICK_STOP:
        enabled = state in {PowerState.OPERATION_ENABLED, PowerState.QUICK_STOP_ACTIVE}
        return PowerState.QUICK_STOP_ACTIVE if enabled else PowerState.SWITCH_ON_DISABLED
    return _towards_enabled(state, controlword & _ENABLE)


def _towards_enabled(state: PowerState, command: int) -> PowerState:
    """Return the state after shutdown, switch on or enable operation; the first must be shutdown."""
    if command & _SWITCH_ON == _SHUTDOWN:
        return PowerState.READY_TO_SWITCH_ON
    if state is PowerState.SWITCH_ON_DISABLED:
        return state
    if state is PowerState.QUICK_STOP_ACTIVE:
        return PowerState.OPERATION_ENABLED if command == _ENABLE else state
    return PowerState.OPERATION_ENABLED if command == _ENABLE else PowerState.SWITCHED_ON


def statusword(state: PowerState, *, remote: bool, target_reached: bool, standing: bool) -> int:
    """Return 6041h: the state, voltage enabled, remote, target reached, and speed is zero."""
    word = int(state)
    if state not in _FAULTY and state is not PowerState.QUICK_STOP_ACTIVE:
        word |= 0x20  # the quick stop bit is inverted; its value in the other states is free
    if state in _POWERED:
        word |= 0x10
    return word | remote << 9 | target_reached << 10 | standing << 12


class AbortOption(IntEnum):
    """Values of 6007h: the reaction to the loss of the master."""

    NOTHING = 0
    FAULT = 1
    DISABLE_VOLTAGE = 2
    QUICK_STOP = 3


class DriveDevice(Device):
    """A drive whose motor has the demanded `velocity` [increments/s]; only ramps limit accelerations."""

    def __init__(
        self,
        objects: Objects,
        send: Callable[[int, bytes], None],
        radians_per_increment: float,
        sensor: Sensor | None,
    ) -> None:
        super().__init__(objects, send)
        self.power = PowerState.SWITCH_ON_DISABLED
        self.velocity = 0.0
        self._target = 0.0
        self._position = 0.0
        self._controlword = 0
        self._radians_per_increment = radians_per_increment
        self.objects.readers.update(
            {
                (0x603F, 0): lambda: self.emergency.code,
                (0x6041, 0): self._statusword,
                (0x6061, 0): lambda: self.objects[0x6060, 0],
                (0x6064, 0): sensor.position if sensor else lambda: round(self._position),
                (0x606B, 0): lambda: round(self.velocity),
                (0x606C, 0): lambda: round(self.velocity),
            }
        )
        modes = {0, _PROFILE_VELOCITY, _CYCLIC_VELOCITY}
        self.objects.checks[0x6060] = refuse_unless(modes.__contains__)
        self.objects.reactions.update(
            {
                0x6040: self._control,
                0x6060: self._retarget,
                0x607F: self._retarget,
                0x60FF: self._retarget,
            }
        )
        self._sensor = sensor

    def advance(self, period: float) -> float:
        """Turn the motor for one period [s]; return the wheel's speed [rad/s]."""
        if self.velocity != self._target:
            self._ramp(period)
        self._position += self.velocity * period
        return self.velocity * self._radians_per_increment

    def _ramp(self, period: float) -> None:
        """Change the velocity towards its target, within 6083h, 6084h or 6085h."""
        if self.power is PowerState.OPERATION_ENABLED and self.objects[0x6060, 0] == _CYCLIC_VELOCITY:
            self.velocity = self._target
        else:
            step = self._acceleration() * period
            self.velocity = max(self.velocity - step, min(self.velocity + step, self._target))
        if not self.velocity:
            self._came_to_rest()

    def _acceleration(self) -> int:
        if self.power is not PowerState.OPERATION_ENABLED:
            return self.objects[0x6085, 0]
        speeds_up = abs(self._target) > abs(self.velocity) and self._target * self.velocity >= 0
        return self.objects[0x6083 if speeds_up else 0x6084, 0]

    def _came_to_rest(self) -> None:
        """End a quick stop or a fault reaction when the velocity is 0."""
        if self.power is PowerState.QUICK_STOP_ACTIVE:
            self.power = PowerState.SWITCH_ON_DISABLED
        elif self.power is PowerState.FAULT_REACTION_ACTIVE:
            self.power = PowerState.FAULT

    def _retarget(self, _sub: int = 0, _value: int = 0) -> None:
        """Set the target velocity: 60FFh, limited by 607Fh, while enabled and not halted; else 0."""
        runs = (
            self.power is PowerState.OPERATION_ENABLED
            and self.objects[0x6060, 0] in {_PROFILE_VELOCITY, _CYCLIC_VELOCITY}
            and not self._controlword & _HALT
        )
        fastest = self.objects[0x607F, 0]
        self._target = float(max(-fastest, min(fastest, self.objects[0x60FF, 0]))) if runs else 0.0
        if not self.velocity and not self._target:
            self._came_to_rest()

    def _control(self, _sub: int, controlword: int) -> None:
        self.power = next_state(self.power, controlword, self._controlword)
        self._controlword = controlword
        self._retarget()

    def _statusword(self) -> int:
        return statusword(
            self.power,
            remote=self.state is NmtState.OPERATIONAL,
            target_reached=self.velocity == self._target,
            standing=not self.velocity,
        )

    def master_lost(self) -> None:
        """Stop by the option in 6007h; unless that is 0, the commanded velocity is set to 0."""
        option = self.objects[0x6007, 0]
        if option == AbortOption.NOTHING:
            return
        self.objects[0x60FF, 0] = 0
        if self.power is PowerState.OPERATION_ENABLED:
            self.power = {
                AbortOption.FAULT: PowerState.FAULT_REACTION_ACTIVE,
                AbortOption.DISABLE_VOLTAGE: PowerState.SWITCH_ON_DISABLED,
                AbortOption.QUICK_STOP: PowerState.QUICK_STOP_ACTIVE,
            }[AbortOption(option)]
        self._retarget()

    def reset_application(self) -> None:
        """Set the state after power-on: standing, switch on disabled, an incremental position at 0."""
        self.power = PowerState.SWITCH_ON_DISABLED
        self.velocity = self._target = self._position = 0.0
        self._controlword = 0
        if self._sensor:
            self._sensor.restart()
