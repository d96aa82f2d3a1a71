"""The words that several verbs let one choose from; nothing is imported here that takes time."""

from __future__ import annotations

from enum import Enum


class TruckChoice(Enum):
    """Which truck to calibrate."""

    a = "a"
    b = "b"


class MethodChoice(Enum):
    """Method whose result --out, --plot and --profile take."""

    exact = "exact"
    weighted = "weighted"
    heading = "heading"
    printed = "printed"


class Format(Enum):
    """What --export writes."""

    ros2 = "ros2"
    vda5050 = "vda5050"
    json = "json"


class KeyRole(Enum):
    """What a key may do."""

    read = "read"
    operate = "operate"
