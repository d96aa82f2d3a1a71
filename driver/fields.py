"""Where the counts stand in a PDO, and how its frames are followed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from driver.load import pdo_lengths

if TYPE_CHECKING:
    from vehicle.parameters import Channel, Encoder, VehicleParameters


@dataclass(frozen=True, slots=True)
class Field:
    """One encoder's field in its PDO.

    Attributes:
        column: of the channel in `vehicle.channels`.
        shift: first bit.
        mask: of its width.
        half: weight of the sign bit; 0 where unsigned.
    """

    column: int
    shift: int
    mask: int
    half: int

    def decode(self, word: int) -> int:
        """Return the raw counts in a PDO read as one little-endian number."""
        raw = (word >> self.shift) & self.mask
        return (raw ^ self.half) - self.half


def field_of(encoder: Encoder, column: int) -> Field:
    """Return the field of an encoder that stands in a column."""
    half = 1 << (encoder.bits - 1) if encoder.signed else 0
    return Field(column, encoder.start_bit, (1 << encoder.bits) - 1, half)


def nodes_of(vehicle: VehicleParameters) -> tuple[int, ...]:
    """Return the node ids of a vehicle's encoders and drives, in order."""
    encoders = {encoder.node for encoder in vehicle.encoders}
    return tuple(sorted(encoders | {drive.node for drive in vehicle.drives}))


@dataclass(slots=True)
class NodeCounts:
    """Frames of one node, counted.

    Attributes:
        received: PDOs that entered a sample.
        missing: SYNCs that its PDO did not answer in time.
        late: PDOs that came after their sample was closed.
        duplicate: second answers to one SYNC.
        wrong_length: PDOs, heartbeats or EMCYs of an impossible length.
        unknown: frames of this node that nothing here expects.
        jumps: readings that no robot can make.
    """

    received: int = 0
    missing: int = 0
    late: int = 0
    duplicate: int = 0
    wrong_length: int = 0
    unknown: int = 0
    jumps: int = 0


@dataclass(slots=True)
class Pdo:
    """One TPDO and its state in the sample that is open.

    Attributes:
        cob_id: of it.
        node: that sends it.
        channels: that it carries.
        fields: where they stand.
        length: expected bytes.
        exact: False where a longer PDO is accepted too, because nobody has read its mapping.
        counts: of its node.
        answered: a valid frame entered the open sample.
        heard: any frame of it came since the last SYNC.
        owes: it missed a SYNC, so that the next frame may be the late answer to that one.
        held: content and times of such a frame, until the sample closes or a second frame tells.
        misses: SYNCs in a row without an answer.
        answers: SYNCs in a row with an answer, since the last miss.
    """

    cob_id: int
    node: int
    channels: tuple[Channel, ...]
    fields: tuple[Field, ...]
    length: int
    counts: NodeCounts
    exact: bool = False
    answered: bool = False
    heard: bool = False
    owes: bool = False
    held: tuple[int, float, float] | None = None
    misses: int = 0
    answers: int = 0


def pdos_of(vehicle: VehicleParameters, counts: dict[int, NodeCounts]) -> dict[int, Pdo]:
    """Return the TPDOs of a vehicle by COB-ID; `counts` by node."""
    pdos = {}
    for cob_id, length in pdo_lengths(vehicle).items():
        mine = [(column, one) for column, one in enumerate(vehicle.encoders) if one.cob_id == cob_id]
        node = mine[0][1].node
        pdos[cob_id] = Pdo(
            cob_id,
            node,
            tuple(one.channel for _, one in mine),
            tuple(field_of(one, column) for column, one in mine),
            length,
            counts[node],
        )
    return pdos
