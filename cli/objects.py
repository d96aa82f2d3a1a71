"""`omnimate sdo` and `omnimate od`: the objects of a node, read, written, and listed."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from omnimate.cli.console import progress_bar, say
from omnimate.cli.descriptions import described_by
from omnimate.cli.errors import CallError
from omnimate.cli.options import AsJson, Bus, Eds, Force, Node, Timeout

if TYPE_CHECKING:
    from contextlib import AbstractContextManager
    from pathlib import Path

    from omnimate.driver.canopen.sdo import Sdo

sdo = typer.Typer(no_args_is_help=True, help="Read or write one object of a node by SDO.")
Kind = Literal[
    "u8", "u16", "u24", "u32", "u64", "i8", "i16", "i24", "i32", "i64", "f32", "f64", "text", "hex"
]  # fmt: skip
Type = Annotated[Kind | None, typer.Option("--type", help="Its type, where no EDS and no profile says it.")]
Object = Annotated[str, typer.Argument(metavar="OBJECT", help="6004h, 1018h:04, or a name in the EDS.")]


@sdo.command()
def read(
    item: Object,
    bus: Bus,
    node: Node,
    eds: Eds = None,
    kind: Type = None,
    timeout: Timeout = 0.5,
    as_json: AsJson = False,
) -> None:
    """Read an object and print its value."""
    from omnimate.driver.canopen.object_values import kind_of, place_of

    with _opened(bus, node, eds, timeout) as objects:
        dictionary = objects.od
        place = place_of(item, dictionary)
        data = objects.read_bytes(*place)
    row = _row(*place, _name(dictionary, *place), kind or kind_of(dictionary, *place), data)
    say(json.dumps(_for_json(row)) if as_json else _value(row))


@sdo.command()
def write(
    item: Object,
    value: Annotated[str, typer.Argument(help="Number (500, 0x1F4, 1F4h, -3, 1.5), text, or bytes in hex.")],
    bus: Bus,
    node: Node,
    eds: Eds = None,
    kind: Type = None,
    timeout: Timeout = 0.5,
    force: Force = False,
) -> None:
    """Write an object; refused while another master works on the bus. The robot may move."""
    from omnimate.driver.canopen.object_values import encode, kind_of, place_of

    with _opened(bus, node, eds, timeout, writes=not force) as objects:
        index, subindex = place_of(item, objects.od)
        known = kind or kind_of(objects.od, index, subindex)
        if known is None:
            raise CallError(f"{index:04X}h:{subindex:02X}: its type is not known; give --type or --eds")
        objects.write_bytes(index, subindex, encode(value, known))


def od(
    bus: Bus,
    node: Node,
    eds: Eds = None,
    timeout: Timeout = 0.5,
    as_json: AsJson = False,
) -> None:
    """Read and print all objects of a node: those of its EDS, or else of the profiles."""
    with _opened(bus, node, eds, timeout) as objects:
        rows = _all(objects, shows_absent=eds is not None)
    if as_json:
        say(json.dumps([_for_json(row) for row in rows], indent=1))
        return
    for row in rows:
        say(f"{row['object']:<9} {row['name']:<44} {_value(row)}".rstrip())


def _opened(
    bus: str, node: int, eds: Path | None, timeout: float, *, writes: bool = False
) -> AbstractContextManager[Sdo]:
    """Open a node by what its EDS describes, or else by the profiles."""
    from omnimate.driver.canopen.node_access import open_node

    described = described_by(eds, node).dictionary if eds is not None else None
    return open_node(bus, node, described, timeout=timeout, writes=writes)


def _all(objects: Sdo, *, shows_absent: bool) -> list[dict[str, Any]]:
    """Return a row for each object; of the profiles' objects, those that the device has."""
    from omnimate.driver.canopen.object_values import kind_of, variables_of
    from omnimate.driver.errors import SdoRefused

    dictionary = objects.od
    objects.read(0x1000)  # a node that is not there is one error
    variables = [variable for variable in variables_of(dictionary) if variable.readable]
    rows = []
    with progress_bar("reading") as progress:
        for number, variable in enumerate(variables):
            index, subindex = variable.index, variable.subindex
            name = _name(dictionary, index, subindex)
            try:
                data = objects.read_bytes(index, subindex)
            except SdoRefused as refused:
                if shows_absent:
                    rows.append(_row(index, subindex, name, None, None) | {"error": refused.problem})
            else:
                rows.append(_row(index, subindex, name, kind_of(dictionary, index, subindex), data))
            progress(number + 1, len(variables))
    return rows


def _row(index: int, subindex: int, name: str, kind: str | None, data: bytes | None) -> dict[str, Any]:
    from omnimate.driver.canopen.object_values import decode

    row: dict[str, Any] = {"object": f"{index:04X}h:{subindex:02X}", "name": name}
    if data is not None:
        row |= {"type": kind, "value": decode(data, kind), "bytes": data.hex()}
    return row


def _for_json(row: dict[str, Any]) -> dict[str, Any]:
    """Return a row whose value is null where JSON has no number: nan and infinities; `bytes` has them."""
    value = row.get("value")
    return row | {"value": None} if isinstance(value, float) and not math.isfinite(value) else row


def _name(dictionary: Any, index: int, subindex: int) -> str:  # noqa: ANN401  # of a library of another room
    variable = dictionary.get_variable(index, subindex)
    return "" if variable is None else str(variable.qualname).replace(f" {index:04X}h", "")


def _value(row: dict[str, Any]) -> str:
    """Return a value as a line shows it: integers also as the bytes are written, in hexadecimal."""
    if "error" in row:
        return str(row["error"])
    value = row["value"]
    if isinstance(value, int):
        digits = bytes.fromhex(row["bytes"])[::-1].hex().upper()
        return f"{value} ({digits}h)"
    return str(value)
