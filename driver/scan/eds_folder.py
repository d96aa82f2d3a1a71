"""Finds the EDS or DCF file that fits a device, by vendor, product and revision."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING

from omnimate.driver.canopen.eds import load_eds
from omnimate.driver.canopen.object_values import default_of
from omnimate.driver.errors import EdsError
from omnimate.driver.scan.node import IDENTITY

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from pathlib import Path

    from canopen.objectdictionary import ObjectDictionary

    from omnimate.driver.scan.node import NodeReading

SUFFIXES = frozenset({".eds", ".dcf"})
ANY_NODE = 1  # node id with which a file is read; its identity does not depend on it


class Fit(IntEnum):
    """How well a file fits a device, the better the higher."""

    NOT = 0
    VENDOR = 1
    OTHER_REVISION = 2
    SAME_BEHAVIOUR = 3  # the upper half of the revision number is that of the CANopen behaviour (CiA 301)
    WHOLE = 4


FITS_IN_WORDS = {
    Fit.VENDOR: "names the vendor alone",
    Fit.OTHER_REVISION: "is of another revision",
    Fit.SAME_BEHAVIOUR: "is of another minor revision",
    Fit.WHOLE: "",
}


@dataclass(frozen=True, slots=True)
class DescribedDevice:
    """The device that a file describes."""

    path: Path
    vendor: int | None  # vendor id; None where the file does not state it
    product: int | None  # product code; None where the file does not state it
    revision: int | None  # revision number; None where the file does not state it
    device_type: int | None  # 1000h; None where the file does not state it

    def fit(self, node: NodeReading) -> Fit:
        """Return how well the file fits a node."""
        if self.vendor is None or self.vendor != node.vendor:
            return Fit.NOT
        if self.product is None:
            is_same_type = self.device_type in {None, node.device_type}
            return Fit.VENDOR if is_same_type else Fit.NOT
        if self.product != node.product:
            return Fit.NOT
        if self.revision is None or self.revision == node.revision:
            return Fit.WHOLE
        is_same = node.revision is not None and self.revision >> 16 == node.revision >> 16
        return Fit.SAME_BEHAVIOUR if is_same else Fit.OTHER_REVISION


@dataclass(frozen=True, slots=True)
class FittingFile:
    """The file that fits a node best."""

    path: Path
    fit: Fit  # how well it fits
    others: tuple[Path, ...] = ()  # files that fit as well

    def in_words(self) -> str:
        """Return its name, and what does not fit."""
        words = [self.path.name, FITS_IN_WORDS[self.fit], *(f"or {path.name}" for path in self.others)]
        return ", ".join(word for word in words if word)


def described_devices(
    folder: Path, on_error: Callable[[EdsError], None] = lambda _error: None
) -> tuple[DescribedDevice, ...]:
    """Return the devices that the EDS and DCF files below a folder describe; unreadable ones are skipped."""
    devices = []
    for path in sorted(folder.rglob("*")):
        if path.suffix.lower() in SUFFIXES:
            try:
                devices.append(_described(path, load_eds(path, ANY_NODE).dictionary))
            except EdsError as error:
                on_error(error)
    return tuple(devices)


def fitting_file(node: NodeReading, devices: Iterable[DescribedDevice]) -> FittingFile | None:
    """Return the file that fits a node best, None where none does."""
    fits = [(device.fit(node), device.path) for device in devices]
    best = max((fit for fit, _ in fits), default=Fit.NOT)
    if best is Fit.NOT:
        return None
    paths = [path for fit, path in fits if fit is best]
    return FittingFile(paths[0], best, tuple(paths[1:]))


def _described(path: Path, dictionary: ObjectDictionary) -> DescribedDevice:
    """Return the device by [DeviceInfo], or else by 1018h; a 0 counts as not stated."""
    information = dictionary.device_information
    stated = (information.vendor_number, information.product_number, information.revision_number)
    vendor, product, revision = (
        number or default_of(dictionary, IDENTITY, subindex) or None
        for subindex, number in enumerate(stated, start=1)
    )
    return DescribedDevice(path, vendor, product, revision, default_of(dictionary, 0x1000, 0) or None)
