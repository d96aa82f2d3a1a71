"""The reader of a robot on a bus, and its samples as they come, with a status line."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING

from omnimate.cli.console import status_line
from omnimate.cli.descriptions import descriptions_of

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterable
    from pathlib import Path

    from omnimate.driver.robot.configure import ConfigurationReport
    from omnimate.driver.robot.driver import Driver
    from omnimate.driver.robot.passive import PassiveReader
    from omnimate.driver.robot.recorder import Recorder
    from omnimate.vehicle.parameters import VehicleParameters
    from omnimate.vehicle.sample import Sample


def open_reader(
    robot: VehicleParameters,
    bus: str,
    recorder: Recorder | None = None,
    *,
    listen_only: bool,
    flight_recorder: Path | None = None,
) -> tuple[Driver | PassiveReader, ConfigurationReport | None]:
    """Return a reader that is ready to give samples, and how its nodes are configured if it may send."""
    from omnimate.driver.robot.driver import open_driver
    from omnimate.driver.robot.passive import PassiveReader

    if listen_only:
        return PassiveReader(robot, bus, recorder=recorder), None
    return open_driver(robot, bus, recorder, descriptions_of(robot), flight_recorder)


def follow(
    samples: Iterable[Sample], seconds: float | None, status: Callable[[Sample, float], str]
) -> Generator[Sample]:
    """Yield samples until the time is up or the source ends, and show a status line until it is closed.

    `status` returns the line for the last sample and the time since the first one [s].
    """
    first = math.nan
    with status_line() as show:
        for sample in samples:
            first = sample.time if math.isnan(first) else first
            yield sample
            passed = sample.time - first
            show(partial(status, sample, passed))
            if seconds is not None and passed >= seconds:
                return
