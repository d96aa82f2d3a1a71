"""The verbs of the command: where the code of each is, and the line that `omnimate --help` shows."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Annotated

import typer
from typer.core import TyperGroup

from omnimate import __version__
from omnimate.cli.console import out

if TYPE_CHECKING:
    from typer._click import Command, Context, HelpFormatter

WIDTH = 120  # characters of a line of help, on a terminal that has as many


# The verbs in groups, each with the first line of its docstring, or the help of its group of verbs.
GROUPS = {
    "Start here": {
        "demo": "Drive UMBmark with a simulated robot on a virtual bus, calibrate it, drive again.",
        "simulate": "Simulate a robot that drives a protocol, and write its recording: arrays, no bus.",
        "record": "Read the encoders of a robot from its bus and write a recording, until Ctrl-C.",
        "replay": "Summarise a recording or a log and its odometry, or send its frames onto a bus again.",
    },
    "Calibrate": {
        "umbmark": "Begin with this: calibrate wheelbase and wheel diameters from squares (UMBmark).",
        "calibrate": "In place of umbmark: calibrate from any drive whose absolute poses are measured.",
        "drift": "Later, from new recordings: say whether it is time to calibrate again.",
        "design": "Compare drives before driving: the Cramer-Rao bound of what each identifies.",
        "profile": "Parameters by name for several floors or loads: list, or put one into vehicle.toml.",
    },
    "Locate and diagnose": {
        "track": "Show the pose by odometry, IPEC and the filter, with what was corrected and why.",
        "diagnose": "Compare recordings with a simulation: where they differ, which physics is missing.",
    },
    "Bus": {
        "monitor": "Watch a bus in the terminal: rates, values, node states, odometry. Sends nothing.",
        "dump": "Print the frames of a log or of a live bus, all or those that are asked for.",
        "scan": "Find who is on a bus by listening and reading alone, and draft a vehicle.toml.",
        "listen": "Find what an unknown bus carries: nodes, PDOs, signals, wheels. Sends nothing.",
        "sdo": "Read or write one object of a node by SDO.",
        "od": "Read and print all objects of a node: those of its EDS, or else of the profiles.",
        "nmt": "Send an NMT command, and print the states that heartbeats and boot-ups then say.",
        "lss": "Find devices without a node id, and give them one (CiA 305).",
        "dcf": "Compare a device with the values that a DCF states, or write them to it.",
        "conform": "Check a device against CiA 301, 305, 402 and 406, without driving it.",
        "sim": "Serve the bus of a simulated vehicle to other processes by the socketcand protocol.",
    },
    "Files": {
        "import": "Make recording folders from bus logs, CSV files or ROS bags.",
        "export": "Write a recording or a log for Foxglove, PlotJuggler, ROS 2, evo, Wireshark, pandas.",
        "dbc": "Write a DBC file with which other tools decode the same values.",
    },
    "Fleet and service": {
        "fleet": "Recordings of many robots: which robot is faulty, which place of the floor is bad.",
        "serve": "Serve calibration, recordings, diagnoses and fleets over REST, with a web page.",
        "key": "API keys of the service: add, list, revoke.",
    },
}
HELP = {name: line for verbs in GROUPS.values() for name, line in verbs.items()}
# Module in this package and function or group of verbs in it, of verbs that are not in `NAME:NAME`.
_PLACES = {
    "demo": "demo.verb:demo",
    "umbmark": "umbmark.verb:umbmark",
    "profile": "profile:app",
    "track": "track.verb:track",
    "monitor": "monitor.verb:monitor",
    "sdo": "objects:sdo",
    "od": "objects:od",
    "nmt": "nodes:nmt",
    "lss": "nodes:lss",
    "sim": "simulate:sim",
    "import": "importing:app",
    "dbc": "export:dbc",
    "fleet": "fleet.verb:app",
    "key": "serve:keys",
}


def place_of(name: str) -> tuple[str, str]:
    """Return the module of a verb, and its function or group of verbs in it."""
    module, _, target = _PLACES.get(name, f"{name}:{name}").partition(":")
    return f"omnimate.cli.{module}", target


class VerbGroup(TyperGroup):
    """The command with all its verbs, of which only the one that is called is loaded."""

    def format_commands(self, ctx: Context, formatter: HelpFormatter) -> None:  # noqa: ARG002  # typer's
        """Write the verbs in their groups, each with the whole of its line."""
        width = max(map(len, HELP))
        for group, verbs in GROUPS.items():
            with formatter.section(group):
                formatter.write_dl([(f"{name:<{width}}", line) for name, line in verbs.items()])

    def resolve_command(self, ctx: Context, args: list[str]) -> tuple[str | None, Command | None, list[str]]:
        """Return the verb that a call names, loaded, and the rest of the call."""
        name, command, rest = super().resolve_command(ctx, args)
        return name, command if name is None else load_verb(name), rest


def load_verb(name: str) -> Command:
    """Return a verb with its options."""
    module, target_name = place_of(name)
    target = getattr(import_module(module), target_name)
    holder = typer.Typer(add_completion=False, rich_markup_mode=None)  # units in brackets are no markup
    if isinstance(target, typer.Typer):
        holder.add_typer(target, name=name)
    else:
        holder.command(name)(target)
    return typer.main.get_group(holder).commands[name]


def command() -> typer.Typer:
    """Return the command, with the name and one line of help of every verb."""
    app = typer.Typer(
        name="omnimate",
        cls=VerbGroup,
        help="""Odometry that a robot fleet trusts: read, calibrate, simulate.

        Begin with `omnimate demo`, which needs no robot. With a robot: `record` squares, calibrate it by
        `umbmark`, and see by `track` where it is.""",
        no_args_is_help=True,
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"], "max_content_width": WIDTH},
    )
    app.callback()(_options)
    for name, line in HELP.items():
        app.command(name, help=line)(_not_loaded)
    return app


def whole_command() -> TyperGroup:
    """Return the command with every verb loaded, to read all options."""
    group = typer.main.get_group(command())
    group.commands = {name: load_verb(name) for name in HELP}
    return group


def _print_version(wanted: bool) -> None:
    """Print the version and end, where the call asks for it."""
    if wanted:
        out.print(f"omnimate {__version__}")
        raise typer.Exit


def _options(
    _version: Annotated[
        bool, typer.Option("--version", help="Print the version.", callback=_print_version, is_eager=True)
    ] = False,
) -> None:
    """Take the options of the command itself."""


def _not_loaded() -> None:
    """Placeholder of a verb in the list; `VerbGroup` loads the verb before it is called."""
