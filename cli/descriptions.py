"""Descriptions of the frames on a bus, from a vehicle, DBC and EDS files, and the SDO traffic."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import typer

from omnimate.cli.console import warn
from omnimate.cli.errors import CallError
from omnimate.files.logs.decoding import FrameDecoder

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from omnimate.driver.canopen.eds import Eds
    from omnimate.files.logs.signals import Signal
    from omnimate.vehicle.parameters import VehicleParameters


class Descriptions(NamedTuple):
    """Descriptions of the frames on a bus, from files.

    The robot is None if unknown; EDS and DCF files are by node, signals of DBC files by identifier.
    """

    vehicle: VehicleParameters | None
    eds: Mapping[int, Eds]
    dbc: Mapping[int, Sequence[Signal]]

    def decoder(self, seen: Mapping[tuple[int, int, int], int]) -> FrameDecoder:
        """Return a decoder of frames by the vehicle, else by DBC, else by the PDO mapping.

        `seen` are the PDO parameters that SDO traffic showed, by node, index and sub-index.
        """
        signals: dict[int, Sequence[Signal]] = {}
        if self.eds or seen:
            from omnimate.driver.canopen.mapped_signals import default_objects, mapped_signals

            dictionaries = {node: file.dictionary for node, file in self.eds.items()}
            objects = dict(seen)
            for node, dictionary in dictionaries.items():
                objects = default_objects(dictionary, node) | objects
            signals.update(mapped_signals(objects, dictionaries))
        return FrameDecoder(self.vehicle, {**signals, **self.dbc})


def descriptions(vehicle: VehicleParameters | None, dbc: Sequence[Path], eds: Sequence[str]) -> Descriptions:
    """Return what the files that are given say of the frames on a bus.

    The EDS or DCF files are given as `NODE=FILE`.

    Raises:
        CallError: An EDS is not given as `NODE=FILE`.
        BadParameter: An EDS is not there.
        EdsError: An EDS cannot be read.
        LogError: A DBC file cannot be read.
    """
    named = {} if vehicle is None else descriptions_of(vehicle, may_miss=True)
    signals: dict[int, Sequence[Signal]] = {}
    if dbc:
        from omnimate.files.logs.dbc import read_dbc

        for path in dbc:
            signals.update(read_dbc(path))
    return Descriptions(vehicle, named | dict(map(_described, eds)), signals)


def described_by(path: Path, node: int) -> Eds:
    """Return what an EDS or DCF file describes, and warn of what had to be repaired.

    Raises:
        EdsError: The file cannot be read.
    """
    from omnimate.driver.canopen.eds import load_eds

    eds = load_eds(path, node)
    for remark in eds.remarks:
        warn(f"{path}: {remark}")
    return eds


def descriptions_of(vehicle: VehicleParameters, *, may_miss: bool = False) -> dict[int, Eds]:
    """Return what the EDS and DCF files that a vehicle names describe, and warn of what had to be repaired.

    With `may_miss`, files that are not there are left out with a warning, as those of a recording's robot.

    Raises:
        EdsError: A file cannot be read.
    """
    files = {node: Path(path) for node, path in vehicle.eds_files.items()}
    if may_miss:
        warn_of_missing_eds(vehicle)
    return {node: described_by(path, node) for node, path in files.items() if path.is_file() or not may_miss}


def warn_of_missing_eds(vehicle: VehicleParameters) -> None:
    """Warn of each EDS or DCF file that a vehicle names and that is not there."""
    for path in vehicle.eds_files.values():
        if not Path(path).is_file():
            warn(f"{path}: not there; the PDOs of its node are decoded without it")


def vehicle_of(path: Path | None, source: Path | None = None) -> VehicleParameters | None:
    """Return the robot that was asked for, or the one of a recording folder."""
    if path is None and source is not None and source.is_dir():
        from omnimate.files.recordings.folder import VEHICLE

        path = source / VEHICLE
    if path is None:
        return None
    from omnimate.vehicle.file import load_vehicle

    return load_vehicle(path)


def _described(text: str) -> tuple[int, Eds]:
    node, equals, path = text.partition("=")
    if not equals or not node.isdigit() or not 1 <= int(node) <= 127:
        raise CallError(f"--eds {text}: expected NODE=FILE, such as 5=encoder.eds")
    if not Path(path).exists():
        raise typer.BadParameter(f"--eds {text}: Path '{path}' does not exist.")
    return int(node), described_by(Path(path), int(node))
