"""`omnimate scan`: the nodes on a bus, and a `vehicle.toml` drafted from them."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from omnimate.cli.console import progress_bar, report_problem, say, warn
from omnimate.cli.errors import CallError
from omnimate.cli.nodes import IDENTITY
from omnimate.cli.options import AsJson, Bus, Timeout
from omnimate.cli.tables import new_table, show

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rich.table import Table

    from omnimate.driver.canopen.pdo_parameters import PdoSetting
    from omnimate.driver.scan.eds_folder import FittingFile
    from omnimate.driver.scan.node import NodeReading
    from omnimate.driver.scan.scan import Scan


def scan(
    bus: Bus,
    eds: Annotated[
        Path | None,
        typer.Option(
            exists=True,
            file_okay=False,
            help="Folder with EDS and DCF files, of which those that fit are named.",
        ),
    ] = None,
    write: Annotated[Path | None, typer.Option(help="vehicle.toml to draft; it must not exist yet.")] = None,
    wait: Annotated[
        float, typer.Option(help="Time in which late devices may boot [s].", min=0.0, max=3600.0)
    ] = 2.0,
    timeout: Timeout = 0.5,
    lss: Annotated[
        bool, typer.Option("--lss", help="Look for devices without a node id, too (CiA 305).")
    ] = False,
    assign: Annotated[
        int | None,
        typer.Option(
            help="With --lss, give them node ids: this one, then those that are free.", min=1, max=127
        ),
    ] = None,
    force: Annotated[
        bool, typer.Option("--force", help="Ask all node ids, and use LSS, even if another master is active.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Find who is on a bus by listening and reading alone, and draft a vehicle.toml."""
    from omnimate.driver.bus.bus import open_bus
    from omnimate.driver.scan.scan import scan as look

    if assign is not None and not lss:
        raise CallError("--assign gives node ids by LSS; add --lss")
    if write is not None and write.exists():
        raise CallError(f"{write}: exists already; name a new file, or remove it")
    with open_bus(bus) as opened, progress_bar("reading nodes") as progress:
        result = look(
            opened, bus, wait=wait, timeout=timeout, asks_lss=lss, first_id=assign, force=force,
            progress=progress,
        )  # fmt: skip
    files = {} if eds is None else _fitting(result, eds)
    if as_json:
        say(json.dumps(_fields(result, files), indent=1))
    else:
        _show(result, files)
    if write is not None:
        _write(result, bus, files, write)
        if not as_json:
            say(f"drafted: {write}")
    for node in result.nodes:
        if node.remark:
            report_problem(f"node {node.node}: {node.remark}")


def _fitting(result: Scan, folder: Path) -> dict[int, FittingFile]:
    """Return the file that fits each node, by node id."""
    from omnimate.driver.scan.eds_folder import described_devices, fitting_file

    devices = described_devices(folder, lambda error: warn(str(error)))
    if not devices:
        warn(f"{folder}: no EDS or DCF file that can be read")
    files = {node.node: fitting_file(node, devices) for node in result.nodes}
    return {node: file for node, file in files.items() if file is not None}


def _write(result: Scan, bus: str, files: Mapping[int, FittingFile], path: Path) -> None:
    from omnimate.driver.bus.adapters import BusUrl
    from omnimate.driver.scan.draft import draft_vehicle
    from omnimate.vehicle.atomic import write_text

    folder = path.resolve().parent
    paths = {node: Path(os.path.relpath(file.path, folder)).as_posix() for node, file in files.items()}
    write_text(path, draft_vehicle(result, bus, BusUrl.of(bus).bitrate, paths))


def _show(result: Scan, files: Mapping[int, FittingFile]) -> None:
    say(_bus_in_words(result))
    if not result.nodes:
        say("no node: check the power, the bit rate, and the terminating resistors")
    else:
        for table in (_nodes(result), _identities(result, files), _pdos(result)):
            if table.row_count:
                show(table, folds=True)
    for identity in result.without_id:
        given = next((node for node, named in result.given.items() if named == identity), None)
        what = ", ".join(f"{name} {_hex(value)}" for name, value in zip(IDENTITY, identity, strict=True))
        say(f"{'without a node id' if given is None else f'now node {given}'}: {what}")
    sent = ", ".join(f"{count} frames of {what}" for what, count in sorted(result.sent.items()))
    say(f"sent: {sent or 'nothing'}; nothing else")


def _bus_in_words(result: Scan) -> str:
    period = result.traffic.sync_period
    counter = " with a counter" if result.traffic.has_counter else ""
    sync = "no SYNC" if period is None else f"SYNC every {1e3 * period:.1f} ms{counter}"
    if not result.has_other_master:
        return f"{sync}; no other master"
    masters = ", ".join(sorted(result.traffic.masters))
    return f"{sync}; another master works here ({masters})"


def _nodes(result: Scan) -> Table:
    heads = ("node", "device", "state", "kept alive by", "name, versions")
    rows = (
        (
            str(node.node),
            node.type_in_words or "-",
            _state(result, node),
            _alive(result, node),
            ", ".join(text for text in (node.name, node.hardware, node.software) if text) or "-",
        )
        for node in result.nodes
    )
    return new_table("nodes", heads, rows=rows)


def _identities(result: Scan, files: Mapping[int, FittingFile]) -> Table:
    heads = ("node", *IDENTITY, *(["EDS that fits"] if files else []))
    table = new_table("identities, 1018h", heads)
    for node in result.nodes:
        if node.vendor is not None:
            texts = [str(node.node), *(_hex(getattr(node, name)) for name in IDENTITY)]
            if files:
                texts.append(files[node.node].in_words() if node.node in files else "-")
            table.add_row(*texts)
    return table


def _pdos(result: Scan) -> Table:
    table = new_table("PDOs that are on", ("node", "PDO", "COB-ID", "sent", "carries"))
    for node in result.nodes:
        for setting in (*node.tpdos, *node.rpdos):
            if setting.is_valid:
                carried = ", ".join(entry.in_words() for entry in setting.entries) or "nothing"
                texts = (str(node.node), setting.name, f"{setting.cob_id:03X}h", _sent(setting), carried)
                table.add_row(*texts)
    return table


def _state(result: Scan, node: NodeReading) -> str:
    from omnimate.files.logs.canopen_words import nmt_state_in_words

    state = result.state(node)
    if state is not None:
        return nmt_state_in_words(state or BOOTED)
    return "not stopped" if node.device_type is not None else "-"


BOOTED = 0x7F  # a node whose boot-up was heard last is pre-operational


def _alive(result: Scan, node: NodeReading) -> str:
    heard = result.traffic.heartbeat_period(node.node)
    period = node.heartbeat or (0.0 if node.node in result.traffic.guarded else heard or 0.0)
    if period:
        return f"heartbeat {period:.3g} s"
    if node.node in result.traffic.guarded:
        return "node guarding"
    return f"guarding {node.guarding:.3g} s" if node.guarding else "nothing"


def _sent(setting: PdoSetting) -> str:
    kind = setting.transmission
    if kind <= 240:
        return {0: "on SYNC, if changed", 1: "on SYNC"}.get(kind, f"every {kind} SYNCs")
    if kind in {252, 253}:
        return "when asked"
    return f"{setting.timer} ms, changes" if setting.timer else "at changes"


def _hex(value: int | None) -> str:
    return "-" if value is None else f"{value:X}h"


def _fields(result: Scan, files: Mapping[int, FittingFile]) -> dict[str, Any]:
    return {
        "sync_period": result.traffic.sync_period,
        "other_master": sorted(result.traffic.masters),
        "sent": dict(result.sent),
        "nodes": [_node_fields(result, node, files.get(node.node)) for node in result.nodes],
        "without_id": [
            dict(zip(IDENTITY, identity, strict=True))
            | {"given": next((node for node, named in result.given.items() if named == identity), None)}
            for identity in result.without_id
        ],
    }


def _node_fields(result: Scan, node: NodeReading, file: FittingFile | None) -> dict[str, Any]:
    return {
        "node": node.node,
        "device_type": node.device_type,
        "profile": node.profile,
        "device": node.type_in_words,
        "state": _state(result, node),
        **{name: getattr(node, name) for name in (*IDENTITY, "name", "hardware", "software")},
        "heartbeat": node.heartbeat,
        "guarding": node.guarding,
        "pdos": [
            {
                "pdo": setting.name,
                "cob_id": setting.cob_id,
                "is_on": setting.is_valid,
                "transmission": setting.transmission,
                "inhibit": setting.inhibit,
                "timer": setting.timer,
                "carries": [
                    {"object": f"{entry.index:04X}h:{entry.subindex:02X}", "bits": entry.bits}
                    for entry in setting.entries
                ],
            }
            for setting in (*node.tpdos, *node.rpdos)
        ],
        "objects": {f"{index:04X}h:{sub:02X}": value for (index, sub), value in node.objects.items()},
        "eds": None if file is None else {"file": str(file.path), "fit": file.fit.name.lower()},
        "remark": node.remark,
    }
