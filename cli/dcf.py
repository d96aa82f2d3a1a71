"""`omnimate dcf`: a device and the values that a DCF states for it."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from omnimate.cli.console import err, progress_bar, report_problem, say
from omnimate.cli.descriptions import described_by
from omnimate.cli.errors import CallError
from omnimate.cli.options import AsJson, Bus, Force, Node, Timeout

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.driver.canopen.dcf import Difference
    from omnimate.driver.canopen.eds import Eds
    from omnimate.driver.canopen.sdo import Sdo

File = Annotated[
    Path, typer.Argument(metavar="DCF", exists=True, help="Device configuration file (CiA 306).")
]

dcf = typer.Typer(
    no_args_is_help=True, help="Compare a device with the values that a DCF states, or write them to it."
)


@dcf.command()
def compare(file: File, bus: Bus, node: Node, timeout: Timeout = 0.5, as_json: AsJson = False) -> None:
    """Print the objects that are not as the DCF states; exit code 1 where there are any."""
    from omnimate.driver.canopen.node_access import open_node

    eds = _stating(file, node)
    with open_node(bus, node, eds.dictionary, timeout=timeout) as objects:
        wrong = _differences(objects, eds)
    _show(wrong, as_json=as_json)
    if wrong:
        report_problem(f"node {node}: {len(wrong)} objects are not as {file} states")


@dcf.command()
def write(
    file: File, bus: Bus, node: Node, timeout: Timeout = 0.5, force: Force = False, as_json: AsJson = False
) -> None:
    """Write what the DCF states and the device has otherwise, and leave the node pre-operational."""
    from omnimate.driver.canopen.dcf import write_values
    from omnimate.driver.canopen.node_access import open_node
    from omnimate.files.logs.canopen_words import NMT_ID, NMT_PRE_OPERATIONAL

    eds = _stating(file, node)
    with open_node(bus, node, eds.dictionary, timeout=timeout, writes=not force) as objects:
        wrong = _differences(objects, eds)
        left: Sequence[Difference] = ()
        if wrong:
            objects.network.send_message(NMT_ID, bytes([NMT_PRE_OPERATIONAL, node]))
            left = write_values(objects, eds.dictionary, wrong)
    _show(left, as_json=as_json)
    err.print(f"written: {len(wrong) - len(left)} of {len(wrong)} objects that differed", soft_wrap=True)
    if left:
        report_problem(f"node {node}: {len(left)} objects are still not as {file} states")


def _stating(file: Path, node: int) -> Eds:
    """Return what a DCF describes."""
    from omnimate.driver.canopen.dcf import stated_values

    eds = described_by(file, node)
    if not stated_values(eds.dictionary):
        raise CallError(f"{file}: no value is stated; expected a DCF with ParameterValue, not an EDS")
    return eds


def _differences(objects: Sdo, eds: Eds) -> list[Difference]:
    from omnimate.driver.canopen.dcf import differences

    objects.read(0x1000)  # a node that is not there is one error
    with progress_bar("comparing") as progress:
        return list(differences(objects, eds.dictionary, progress=progress))


def _show(wrong: Sequence[Difference], *, as_json: bool) -> None:
    if as_json:
        say(json.dumps([asdict(difference) for difference in wrong], indent=1))
        return
    for difference in wrong:
        say(difference.in_words())
