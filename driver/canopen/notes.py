"""What is said about a node while it is configured."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(slots=True)
class Notes:
    """Lines for an operator, collected while one node is configured.

    Attributes:
        read: What was read from the node before anything was changed.
        changed: What the driver changed.
        remarks: What an operator should check.
    """

    read: list[str] = field(default_factory=list)
    changed: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
