"""Faults as text: `reboot:node=2,at=30` is the fault `reboot` of node 2 at 30 s."""

from __future__ import annotations

from dataclasses import fields
from functools import partial
from typing import TYPE_CHECKING, Any, cast

from omnimate.vcan_sim.errors import FaultError
from omnimate.vcan_sim.faults import FAULTS
from omnimate.vcan_sim.key_values import BYTES, INTEGER, NUMBER, Kind, read_values

if TYPE_CHECKING:
    from omnimate.vcan_sim.faults import DeviceFault

_KINDS: dict[str, Kind] = {"float": NUMBER, "int": INTEGER, "int | None": INTEGER, "str | None": BYTES}


def parse_fault(text: str) -> DeviceFault:
    """Return the fault that a text such as `emcy:node=3,at=12.5,duration=2,code=0x5000` describes.

    Raises:
        FaultError: The name or a key is not known, the node is missing, or a value cannot be read or is
            out of its bounds.
    """
    name, _, rest = text.partition(":")
    faults = {fault.name: fault for fault in FAULTS}
    if name not in faults:
        raise FaultError(text, f"unknown name {name!r}; expected one of {', '.join(faults)}")
    kinds = {field.name: _KINDS[str(field.type)] for field in fields(faults[name])}
    values = read_values(rest, kinds, partial(FaultError, text))
    if "node" not in values:
        raise FaultError(text, f"expected a node, as in `{name}:node=2`")
    return faults[name](**cast("dict[str, Any]", values))
