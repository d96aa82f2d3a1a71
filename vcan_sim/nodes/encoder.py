"""A CiA 406 encoder, with one sensor or several."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.vcan_sim.errors import Abort, SdoAbort
from omnimate.vcan_sim.nodes.device import Device

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from omnimate.vcan_sim.nodes.objects import Objects
    from omnimate.vcan_sim.nodes.sensor import Sensor

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
