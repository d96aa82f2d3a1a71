"""Opens a driver whose encoders are configured, or no driver at all."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.driver.robot.driver import Driver

if TYPE_CHECKING:
    from collections.abc import Mapping

    from omnimate.driver.canopen.eds import Eds
    from omnimate.driver.canopen.network import FrameSink
    from omnimate.driver.robot.configuration import ConfigurationReport
    from omnimate.vehicle.parameters import VehicleParameters


def open_driver(
    vehicle: VehicleParameters,
    bus: str,
    recorder: FrameSink | None = None,
    descriptions: Mapping[int, Eds] | None = None,
) -> tuple[Driver, ConfigurationReport]:
    """Return a driver whose encoders are configured and send, and what configuring them showed.

    Args:
        vehicle: The robot as its `vehicle.toml` describes it.
        bus: URL of the bus, such as `socketcan://can0`.
        recorder: Receives every frame; None for none.
        descriptions: What EDS and DCF files describe, by node id; see `load_descriptions`.

    Raises:
        DriverError: The bus cannot be opened, or a node is not as it must be; the bus is closed again.
    """
    driver = Driver(vehicle, bus, recorder=recorder, descriptions=descriptions)
    try:
        return driver, driver.configure()
    except BaseException:
        driver.close()
        raise
