"""`omnimate conform`: does a device do what the CANopen standards ask for?"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from omnimate.cli.console import err, say
from omnimate.cli.nodes import open_probe
from omnimate.cli.options import AsJson, Bus, Force, Node, Timeout

if TYPE_CHECKING:
    from omnimate.driver.conformance.run import Result


def conform(
    bus: Bus,
    node: Node,
    most: Annotated[
        Literal["reads", "writes", "resets", "stores"],
        typer.Option(
            help="What may be done to it: read; write and put back; reset and start it too; store too, and "
            "take its node id away for a moment."
        ),
    ] = "resets",
    timeout: Timeout = 0.5,
    force: Force = False,
    as_json: AsJson = False,
) -> None:
    """Check a device against CiA 301, 305, 402 and 406, without driving it.

    What it does not do is printed with the reason. The device must not drive meanwhile.
    """
    from omnimate.driver.conformance.run import conform as run

    results = []
    with open_probe(bus, node, force=force, timeout=timeout) as probe:
        for result in run(probe, most):
            results.append(result)
            if not as_json:
                say(_line(result))
    if as_json:
        say(json.dumps([_fields(result) for result in results], indent=1))
    counts = {name: sum(r.outcome == name for r in results) for name in ("passed", "failed", "absent")}
    err.print(", ".join(f"{count} {name}" for name, count in counts.items()))
    if counts["failed"]:
        raise typer.Exit(1)


def _line(result: Result) -> str:
    check = result.check
    return f"{check.standard}  {check.subject:<31} {result.outcome:<7} {result.reason}".rstrip()


def _fields(result: Result) -> dict[str, str]:
    check = result.check
    return {
        "standard": check.standard,
        "subject": check.subject,
        "demand": check.demand,
        "outcome": result.outcome,
        "reason": result.reason,
    }
