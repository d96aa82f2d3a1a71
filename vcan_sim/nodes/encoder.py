"""A CiA 406 encoder with one sensor or several, each of which reads counts of the plant, latched at SYNC."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.vcan_sim.errors import Abort, SdoAbort
from omnimate.vcan_sim.nodes.device import Device

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from omnimate.vcan_sim.nodes.objects import Objects
    from omnimate.vehicle.parameters import Encoder

_MAX_SPEED = 2**15 - 1  # [counts/s]; the speed value is 16 bits wide and saturates


class Latch:
    """The raw `counts` of all channels at the last SYNC, `period` [s] after `previous`, for all encoders."""

    __slots__ = ("counts", "period", "previous")

    def __init__(self, counts: Sequence[int], period: float) -> None:
        self.counts = self.previous = counts
        self.period = period

    def take(self, counts: Sequence[int]) -> None:
        """Latch the counts of a new SYNC."""
        self.previous, self.counts = self.counts, counts


class Sensor:
    """One encoder's counter, with its preset, code sequence and scaling.

    A wheel's counter loses its count without power; joints and the link are absolute and keep theirs.
    """

    def __init__(self, latch: Latch, column: int, encoder: Encoder) -> None:
        self._latch = latch
        self._column = column
        self._volatile = encoder.channel.count(".") == 1  # a wheel
        self._full_range = encoder.wrap_range
        self._low = -(encoder.wrap_range // 2) if encoder.signed else 0
        self._direction = 1
        self._units = self._resolution = 1
        self._range = self._full_range
        self._is_unmodified = True
        self._origin = 0  # [counts] added to a counter that restarted from 0
        self.offset = 0

    def position(self) -> int:
        """Return the position value [counts] at the last SYNC."""
        counts = self._latch.counts[self._column]
        if self._is_unmodified:
            return counts
        value = self._measured(counts) + self._origin + self.offset
        return (value - self._low) % self._range + self._low

    def speed(self) -> int:
        """Return the speed over the last SYNC period [counts/s], saturated at 16 bits."""
        step = self._measured(self._latch.counts[self._column]) - self._measured(
            self._latch.previous[self._column]
        )
        half = self._range // 2
        step = (step + half) % self._range - half
        return max(-_MAX_SPEED - 1, min(_MAX_SPEED, round(step / self._latch.period)))

    def preset(self, value: int) -> None:
        """Set the current position to `value` [counts]."""
        self.offset = value - self._origin - self._measured(self._latch.counts[self._column])
        self._update_is_unmodified()

    def configure(self, direction: int, units: int, resolution: int, total: int) -> None:
        """Set code sequence (1 or -1), scaling (units per resolution) and range; 0 is the full range."""
        self._direction, self._units, self._resolution = direction, units, resolution
        self._range = total or self._full_range
        self._update_is_unmodified()

    def restart(self) -> None:
        """Set the state after power-on: an incremental counter at 0, default code sequence and scaling."""
        self._direction = self._units = self._resolution = 1
        self._range = self._full_range
        if self._volatile:
            self.offset, self._origin = 0, -self._measured(self._latch.counts[self._column])
        self._update_is_unmodified()

    def _measured(self, counts: int) -> int:
        return self._direction * counts * self._units // self._resolution

    def _update_is_unmodified(self) -> None:
        scaled = self._units != self._resolution or self._range != self._full_range
        self._is_unmodified = not (self._origin or self.offset or scaled) and self._direction == 1


_CODE_SEQUENCE, _SCALING, _LINEAR_DIRECTION = 0x0001, 0x0004, 0x0008  # bits of 6000h


class EncoderDevice(Device):
    """An encoder: 6004h is its first sensor, 6020h:n and 6030h:n are all of them."""

    def __init__(
        self, objects: Objects, send: Callable[[int, bytes], None], sensors: Sequence[Sensor]
    ) -> None:
        super().__init__(objects, send)
        self._sensors = tuple(sensors)
        self.objects.readers[0x6004, 0] = sensors[0].position
        self.objects.readers[0x6500, 0] = lambda: self.objects[0x6000, 0]
        self.objects.readers[0x6509, 0] = lambda: sensors[0].offset
        for number, sensor in enumerate(sensors, start=1):
            self.objects.readers[0x6020, number] = sensor.position
            self.objects.readers[0x6030, number] = sensor.speed
        self.objects.checks[0x6010] = self._check_sensor
        self.objects.reactions.update(
            {
                0x1800: self._mirror_event_timer,
                0x6000: self._configure,
                0x6001: self._configure,
                0x6002: self._configure,
                0x6003: lambda _sub, value: sensors[0].preset(value),
                0x6010: lambda sub, value: sensors[sub - 1].preset(value),
                0x6200: self._mirror_cyclic_timer,
            }
        )

    def reset_application(self) -> None:
        """Set the sensors to their state after power-on: incremental counters at 0."""
        for sensor in self._sensors:
            sensor.restart()

    def _check_sensor(self, sub: int, _value: int) -> None:
        if sub > len(self._sensors):
            raise SdoAbort(Abort.NO_SUBINDEX)

    def _configure(self, _sub: int, _value: int) -> None:
        """Configure the sensors by 6000h, 6001h and 6002h."""
        parameters = self.objects[0x6000, 0]
        reverse = parameters & (_CODE_SEQUENCE | _LINEAR_DIRECTION)
        scaled = bool(parameters & _SCALING) and (0x6001, 0) in self.objects
        resolution = self.objects[0x6501, 0]
        units = self.objects[0x6001, 0] if scaled else resolution
        total = self.objects[0x6002, 0] if scaled else 0
        for sensor in self._sensors:
            sensor.configure(-1 if reverse else 1, units, resolution, total)

    def _mirror_event_timer(self, sub: int, value: int) -> None:
        """Set 6200h to the event timer of TPDO1; both are equal in CiA 406."""
        if sub == 5:
            self.objects[0x6200, 0] = value
        self.configure_pdos()

    def _mirror_cyclic_timer(self, _sub: int, value: int) -> None:
        self.objects[0x1800, 5] = value
        self.configure_pdos()
