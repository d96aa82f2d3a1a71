"""Brings a node back that does not answer SDO: in the NMT state stopped it cannot (CiA 301)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.driver.canopen.network import NMT_PRE_OPERATIONAL, NMT_RESET_COMMUNICATION

if TYPE_CHECKING:
    from collections.abc import Callable

    from omnimate.driver.canopen.sdo import Sdo

_REMEDIES = (
    (NMT_PRE_OPERATIONAL, "set pre-operational"),
    (NMT_RESET_COMMUNICATION, "its communication reset"),
)


def wake(sdo: Sdo, nmt: Callable[[int, int], None]) -> str | None:
    """Have a node answer SDO, if NMT can bring it back.

    Args:
        sdo: Objects of the node.
        nmt: Sends an NMT command to a node: command specifier, node id.

    Returns:
        What it took, in words; None where the node answered at once, or does not answer all the same.

    Raises:
        BusLost: The interface failed.
    """
    if sdo.answers():
        return None
    for command, words in _REMEDIES:
        nmt(command, sdo.node)
        if sdo.answers():
            return f"did not answer SDO, as in NMT state stopped: {words}"
    return None
