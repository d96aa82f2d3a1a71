"""The verbs of the command: where the code of each is, and the line that `omnimate --help` shows."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer
from typer.core import TyperGroup

from omnimate import __version__
from omnimate.cli.console import out

if TYPE_CHECKING:
    from typer._click import Command, Context, HelpFormatter

WIDTH = 120  # characters of a line of help, on a terminal that has as many


class Verb(NamedTuple):
    """A verb, before its code is loaded.

    Attributes:
        place: Its module in this package and the function or group of verbs in it, `module:name`.
        help: The first line of its docstring, or the help of the group.
    """

    place: str
    help: str

    @property
    def module(self) -> str:
        """Name of the module."""
        return f"omnimate.cli.{self.place.partition(':')[0]}"


GROUPS = {
    "Start here": {
        "demo": Verb(
            "demo.verb:demo",
            "Drive UMBmark with a simulated robot on a virtual bus, calibrate it, drive again.",
        ),
        "simulate": Verb(
            "simulate:simulate",
            "Simulate a robot that drives a protocol, and write its recording: arrays, no bus.",
        ),
        "record": Verb(
            "record:record", "Read the encoders of a robot from its bus and write a recording, until Ctrl-C."
        ),
        "replay": Verb(
            "replay:replay",
            "Summarise a recording or a log and its odometry, or send its frames onto a bus again.",
        ),
    },
    "Calibrate": {
        "umbmark": Verb(
            "umbmark.verb:umbmark",
            "Begin with this: calibrate wheelbase and wheel diameters from squares (UMBmark).",
        ),
        "calibrate": Verb(
            "calibrate:calibrate",
            "In place of umbmark: calibrate from any drive whose absolute poses are measured.",
        ),
        "drift": Verb(
            "drift:drift", "Later, from new recordings: say whether it is time to calibrate again."
        ),
        "design": Verb(
            "design:design", "Compare drives before driving: the Cramer-Rao bound of what each identifies."
        ),
        "profile": Verb(
            "profile:app",
            "Parameters by name for several floors or loads: list, or put one into vehicle.toml.",
        ),
    },
    "Locate and diagnose": {
        "track": Verb(
            "track.verb:track",
            "Show the pose by odometry, IPEC and the filter, with what was corrected and why.",
        ),
        "diagnose": Verb(
            "diagnose:diagnose",
            "Compare recordings with a simulation: where they differ, which physics is missing.",
        ),
    },
    "Bus": {
        "monitor": Verb(
            "monitor.verb:monitor",
            "Watch a bus in the terminal: rates, values, node states, odometry. Sends nothing.",
        ),
        "dump": Verb(
            "dump:dump", "Print the frames of a log or of a live bus, all or those that are asked for."
        ),
        "scan": Verb(
            "scan:scan", "Find who is on a bus by listening and reading alone, and draft a vehicle.toml."
        ),
        "listen": Verb(
            "listen:listen", "Find what an unknown bus carries: nodes, PDOs, signals, wheels. Sends nothing."
        ),
        "sdo": Verb("objects:sdo", "Read or write one object of a node by SDO."),
        "od": Verb(
            "objects:od", "Read and print all objects of a node: those of its EDS, or else of the profiles."
        ),
        "nmt": Verb(
            "nodes:nmt", "Send an NMT command, and print the states that heartbeats and boot-ups then say."
        ),
        "lss": Verb("nodes:lss", "Find devices without a node id, and give them one (CiA 305)."),
        "dcf": Verb("dcf:dcf", "Compare a device with the values that a DCF states, or write them to it."),
        "conform": Verb(
            "conform:conform", "Check a device against CiA 301, 305, 402 and 406, without driving it."
        ),
        "sim": Verb(
            "simulate:sim",
            "Serve the bus of a simulated vehicle to other processes by the socketcand protocol.",
        ),
    },
    "Files": {
        "import": Verb("importing:app", "Make recording folders from bus logs, CSV files or ROS bags."),
        "export": Verb(
            "export:export",
            "Write a recording or a log for Foxglove, PlotJuggler, ROS 2, evo, Wireshark, pandas.",
        ),
        "dbc": Verb("export:dbc", "Write a DBC file with which other tools decode the same values."),
    },
    "Fleet and service": {
        "fleet": Verb(
            "fleet.verb:app",
            "Recordings of many robots: which robot is faulty, which place of the floor is bad.",
        ),
        "serve": Verb(
            "serve:serve", "Serve calibration, recordings, diagnoses and fleets over REST, with a web page."
        ),
        "key": Verb("serve:keys", "API keys of the service: add, list, revoke."),
    },
}
VERBS = {name: verb for verbs in GROUPS.values() for name, verb in verbs.items()}


class VerbGroup(TyperGroup):
    """The command with all its verbs, of which only the one that is called is loaded."""

    def format_commands(self, ctx: Context, formatter: HelpFormatter) -> None:  # noqa: ARG002  # typer's
        """Write the verbs in their groups, each with the whole of its line."""
        width = max(map(len, VERBS))
        for group, verbs in GROUPS.items():
            with formatter.section(group):
                formatter.write_dl([(f"{name:<{width}}", verb.help) for name, verb in verbs.items()])

    def resolve_command(self, ctx: Context, args: list[str]) -> tuple[str | None, Command | None, list[str]]:
        """Return the verb that a call names, loaded, and the rest of the call."""
        name, command, rest = super().resolve_command(ctx, args)
        return name, command if name is None else load_verb(name), rest


def load_verb(name: str) -> Command:
    """Return a verb with its options."""
    verb = VERBS[name]
    target = getattr(import_module(verb.module), verb.place.partition(":")[2])
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
    for name, verb in VERBS.items():
        app.command(name, help=verb.help)(_not_loaded)
    return app


def whole_command() -> TyperGroup:
    """Return the command with every verb loaded, to read all options."""
    group = typer.main.get_group(command())
    group.commands = {name: load_verb(name) for name in VERBS}
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
