"""`omnimate nmt` and `omnimate lss`: the states of nodes, and node ids."""

from __future__ import annotations

import json
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Literal, get_args

import typer

from omnimate.cli.console import out, report_problem
from omnimate.cli.errors import CallError
from omnimate.cli.options import AsJson, Bus, Force

if TYPE_CHECKING:
    from collections.abc import Iterator

    from omnimate.driver.canopen.lss import Identity
    from omnimate.driver.conformance.probe import Probe, Reply

ALL = 0
HEARTBEAT_WAIT = 1.5  # [s]; assumption: most devices send a heartbeat each second or more often
BOOT_WAIT = 3.0  # [s] after a reset; assumption
IDENTITY = ("vendor", "product", "revision", "serial")

lss = typer.Typer(no_args_is_help=True, help="Find devices without a node id, and give them one (CiA 305).")


Command = Literal["start", "stop", "preop", "reset", "reset-communication"]
CODES = dict(zip(get_args(Command), (0x01, 0x02, 0x80, 0x81, 0x82), strict=True))


def nmt(
    command: Annotated[Command, typer.Argument(help="What the node shall do.")],
    bus: Bus,
    node: Annotated[str, typer.Option(help="Its node id, or `all`.")],
    force: Force = False,
    as_json: AsJson = False,
) -> None:
    """Send an NMT command, and print the states that heartbeats and boot-ups then say."""
    from omnimate.files.logs.canopen_words import BOOT_UP, nmt_state_in_words

    number = _node(node)
    waited = BOOT_WAIT if command.startswith("reset") else HEARTBEAT_WAIT
    with open_probe(bus, number, force=force) as probe:
        probe.send(0x000, bytes([CODES[command], number]))
        replies = probe.listen(waited, lambda reply: number != ALL and reply.can_id == 0x700 + number)
    states = {
        node_id: nmt_state_in_words(state)
        for node_id, state in sorted(_states(replies).items())
        # a device that has got another node id boots up with that one
        if number in {ALL, node_id} or (command.startswith("reset") and state == BOOT_UP)
    }
    if not states:
        of = bus if number == ALL else f"node {number}"
        report_problem(
            f"{of}: no heartbeat within {waited:g} s after the command; check that the node is there, and "
            "that 1017h is not 0"
        )
    if as_json:
        out.print(json.dumps({str(node): state for node, state in states.items()}))
        return
    for node_id, state in states.items():
        out.print(f"node {node_id}: {state}")


@lss.command()
def find(bus: Bus, force: Force = False, as_json: AsJson = False) -> None:
    """Find one device without a node id by fastscan, and print its identity."""
    from omnimate.driver.canopen.lss import LssMaster

    with open_probe(bus, ALL, force=force) as probe:
        master = LssMaster(probe)
        identity = master.fastscan()
        master.leave()
    if identity is None:
        raise CallError(f"{bus}: no device without a node id answers; expected one with LSS fastscan")
    _print(identity, as_json=as_json)


@lss.command(name="id")
def set_id(
    new: Annotated[int, typer.Argument(min=1, max=127, help="Node id to give.")],
    bus: Bus,
    identity: Annotated[
        str | None,
        typer.Option(help="VENDOR,PRODUCT,REVISION,SERIAL of the device; else the one without a node id."),
    ] = None,
    store: Annotated[bool, typer.Option("--store", help="Have it keep the id without power.")] = False,
    force: Force = False,
    as_json: AsJson = False,
) -> None:
    """Give a device a node id, which it uses at once if it had none, else from its next reset on."""
    from omnimate.driver.canopen.lss import LssMaster

    wanted = _identity(identity)
    with open_probe(bus, ALL, force=force) as probe:
        master = LssMaster(probe)
        there = master.fastscan() if wanted is None else (wanted if master.select(wanted) else None)
        if there is None:
            what = (
                "no device without a node id answers" if wanted is None else f"no device {identity} answers"
            )
            raise CallError(f"{bus}: {what}; check its power, its bit rate, and that it has LSS")
        try:
            if not master.configure_id(new):
                raise CallError(f"{bus}: the device refuses node id {new}")
            if store and not master.store():
                raise CallError(f"{bus}: the device cannot store its node id; leave --store out")
        finally:
            master.leave()
    _print(there, as_json=as_json)


@contextmanager
def open_probe(bus: str, node: int, *, force: bool, timeout: float = 0.1) -> Iterator[Probe]:
    """Open a bus for raw frames; refused while another master works on it, unless forced."""
    from omnimate.driver.bus.bus import open_bus
    from omnimate.driver.canopen.node_access import require_no_other_master
    from omnimate.driver.conformance.probe import Probe

    with open_bus(bus) as can_bus:
        if not force:
            require_no_other_master(can_bus, bus)
        yield Probe(can_bus, node, timeout)


def _states(replies: list[Reply]) -> dict[int, int]:
    """Return the last NMT state of each node."""
    return {
        reply.can_id - 0x700: reply.data[0] & 0x7F
        for reply in replies
        if 0x700 < reply.can_id < 0x780 and len(reply.data) == 1
    }


def _node(text: str) -> int:
    if text == "all":
        return ALL
    if not text.isdigit() or not 1 <= int(text) <= 127:
        raise CallError(f"--node {text}: expected 1 to 127, or all")
    return int(text)


def _identity(text: str | None) -> Identity | None:
    if text is None:
        return None
    try:
        vendor, product, revision, serial = (int(part, 0) for part in text.split(","))
    except ValueError as error:
        raise CallError(f"--identity {text}: expected VENDOR,PRODUCT,REVISION,SERIAL as numbers") from error
    return vendor, product, revision, serial


def _print(identity: Identity, *, as_json: bool) -> None:
    named = dict(zip(IDENTITY, identity, strict=True))
    if as_json:
        out.print(json.dumps(named))
    else:
        out.print(", ".join(f"{name} {number:X}h" for name, number in named.items()))
