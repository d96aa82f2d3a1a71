"""The TPDOs that a vehicle's encoders send, and what is known of each between two SYNCs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnimate.driver.robot.pdo_fields import PdoField, field_of
from omnimate.files.logs.answers import Owed

if TYPE_CHECKING:
    from omnimate.driver.robot.events import NodeCounts
    from omnimate.vehicle.parameters import Channel, VehicleParameters


@dataclass(slots=True)
class ExpectedPdo:
    """One TPDO and its state in the sample that is open.

    Attributes:
        cob_id: COB-ID of the PDO.
        node: Node that sends the PDO.
        channels: Channels that the PDO carries.
        fields: Bits of each channel in the PDO.
        length: Expected length [bytes].
        counts: Frame counters of the node.
        owed: Answers that it owes, so that its next frames may be those.
        is_mapped: Whether the length is that of a mapping that was read from the device.
        is_exact: Whether such a PDO has come, so that no longer one is accepted any more.
        is_timed: Whether it comes by the device's own timer, more than once per SYNC.
        answered: Whether a valid frame entered the open sample.
        heard: Whether any frame of the PDO came since the last SYNC.
        held: Content and times of the last of such frames, until the sample closes.
        frames: Number of such frames since the last SYNC.
        misses: SYNCs in a row without an answer.
        answers: SYNCs in a row with an answer, since the last miss.
        last: Number of the sample that it last entered; None before the first.
        has_booted: Whether a boot-up of its node was heard since then.
        was_started: Whether the node was started after that.
    """

    cob_id: int
    node: int
    channels: tuple[Channel, ...]
    fields: tuple[PdoField, ...]
    length: int
    counts: NodeCounts
    owed: Owed
    is_mapped: bool = False
    is_exact: bool = False
    is_timed: bool = False
    answered: bool = False
    heard: bool = False
    held: tuple[int, float, float] | None = None
    frames: int = 0
    misses: int = 0
    answers: int = 0
    last: int | None = None
    has_booted: bool = False
    was_started: bool = False


def pdo_lengths(vehicle: VehicleParameters) -> dict[int, int]:
    """Return the length that each TPDO of the vehicle needs [bytes], by COB-ID."""
    ends: dict[int, int] = {}
    for encoder in vehicle.encoders:
        ends[encoder.cob_id] = max(ends.get(encoder.cob_id, 0), encoder.start_bit + encoder.bits)
    return {cob_id: (end + 7) // 8 for cob_id, end in ends.items()}


def expected_pdos(vehicle: VehicleParameters, counts: dict[int, NodeCounts]) -> dict[int, ExpectedPdo]:
    """Return the TPDOs of a vehicle by COB-ID; `counts` are the frame counters by node id."""
    pdos = {}
    for cob_id, length in pdo_lengths(vehicle).items():
        carried = [
            (column, encoder) for column, encoder in enumerate(vehicle.encoders) if encoder.cob_id == cob_id
        ]
        node = carried[0][1].node
        pdos[cob_id] = ExpectedPdo(
            cob_id,
            node,
            tuple(encoder.channel for _, encoder in carried),
            tuple(field_of(encoder, column) for column, encoder in carried),
            length,
            counts[node],
            Owed(vehicle.bus.sync_period),
        )
    return pdos
