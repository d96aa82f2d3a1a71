"""Routing of frames to devices: NMT, SDO, heartbeats, LSS, and RPDOs by their COB-IDs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.vcan_sim.nodes.device import SYNC_ID
from omnimate.vcan_sim.nodes.lss import MASTER

if TYPE_CHECKING:
    from collections.abc import Sequence

    import can

    from omnimate.vcan_sim.nodes.device import Device
    from omnimate.vcan_sim.nodes.pdo import Rpdo


class Router:
    """Passes the frames of the bus to the devices that process them."""

    def __init__(self, devices: Sequence[Device]) -> None:
        self._devices = devices
        self._routes: dict[int, list[tuple[Device, Rpdo]]] | None = None

    def invalidate_routes(self) -> None:
        """Look up the RPDOs again at the next frame; for changes of a device's configuration."""
        self._routes = None

    def receive(self, message: can.Message, now: float) -> None:
        """Pass a message, received at a time [s], to all devices that process it."""
        can_id, data = message.arbitration_id, bytes(message.data)
        if message.is_remote_frame:
            for device in self._devices:
                device.on_remote(can_id, now)
        elif can_id == SYNC_ID:
            for device in self._devices:
                device.on_sync(now, data)
        elif can_id == 0x000:
            self._on_nmt(data, now)
        elif 0x600 < can_id <= 0x67F:
            self._on_sdo(can_id - 0x600, data, now)
        elif 0x700 < can_id <= 0x77F:
            for device in self._devices:
                device.on_heartbeat(can_id - 0x700, now)
        elif can_id == MASTER:
            self._on_lss(data, now)
        else:
            self._on_rpdo(can_id, data, now)

    def _on_lss(self, data: bytes, now: float) -> None:
        for device in self._devices:
            device.on_lss(data, now)
        self.invalidate_routes()

    def _on_nmt(self, data: bytes, now: float) -> None:
        if len(data) == 2:
            for device in self._devices:
                if data[1] in {0, device.node}:
                    device.on_nmt(data[0], now)
        self.invalidate_routes()

    def _on_sdo(self, node: int, data: bytes, now: float) -> None:
        for device in self._devices:
            if device.node == node:
                device.on_sdo(data, now)
                self.invalidate_routes()

    def _on_rpdo(self, can_id: int, data: bytes, now: float) -> None:
        if self._routes is None:
            self._routes = self._find_routes()
        for device, rpdo in self._routes.get(can_id, ()):
            device.on_rpdo(rpdo, data, now)

    def _find_routes(self) -> dict[int, list[tuple[Device, Rpdo]]]:
        """Return the receivers of each COB-ID by the current configuration."""
        routes: dict[int, list[tuple[Device, Rpdo]]] = {}
        for device in self._devices:
            for rpdo in device.rpdos:
                if rpdo.valid:
                    routes.setdefault(rpdo.cob_id, []).append((device, rpdo))
        return routes
