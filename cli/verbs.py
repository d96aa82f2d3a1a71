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


class Verb(NamedTuple):
    """A verb, known without its code.

    Attributes:
        place: Its module and the function or group of verbs in it, `module:name`.
        help: The first line of its docstring, or the help of the group.
    """

    place: str
    help: str


VERBS = {
    "demo": Verb(
        "omnimate.cli.demo.verb:demo",
        "Drive UMBmark with a simulated OmniMate on a virtual CAN bus, calibrate it, and drive again.",
    ),
    "sim": Verb(
        "omnimate.cli.sim:sim",
        "Serve the bus of a simulated vehicle to other processes, by the socketcand protocol, until Ctrl-C.",
    ),
    "simulate": Verb(
        "omnimate.cli.simulate:simulate",
        "Simulate a robot that drives a protocol, and write its recording: arrays, no bus.",
    ),
    "record": Verb(
        "omnimate.cli.record:record",
        "Read the encoders of a robot from its bus and write a recording, until Ctrl-C.",
    ),
    "replay": Verb(
        "omnimate.cli.replay:replay",
        "Say what a recording or a log holds and where its odometry leads; or send it onto a bus again.",
    ),
    "track": Verb(
        "omnimate.cli.track.verb:track",
        "Show where the robot is by odometry, IPEC and the filter, with what was corrected and why.",
    ),
    "dump": Verb(
        "omnimate.cli.dump:dump",
        "Print the frames of a log or of a live bus, all or those that are asked for.",
    ),
    "scan": Verb(
        "omnimate.cli.scan:scan",
        "Say who is on a bus, by listening and reading alone, and draft a vehicle.toml from it.",
    ),
    "listen": Verb(
        "omnimate.cli.listen:listen",
        "Say what an unknown bus carries: nodes, PDOs and their signals, wheels. Nothing is sent.",
    ),
    "monitor": Verb(
        "omnimate.cli.monitor.verb:monitor",
        "Watch a bus in the terminal: rates, values, node states, load, odometry, events. Sends nothing.",
    ),
    "sdo": Verb("omnimate.cli.objects:sdo", "Read or write one object of a node by SDO."),
    "od": Verb(
        "omnimate.cli.objects:od",
        "Read all objects of a node, those of its EDS or else those of the profiles, and print them.",
    ),
    "dcf": Verb(
        "omnimate.cli.dcf:dcf", "Compare a device with the values that a DCF states, or write them to it."
    ),
    "nmt": Verb(
        "omnimate.cli.nodes:nmt",
        "Send an NMT command, and print the states that heartbeats and boot-ups then say.",
    ),
    "lss": Verb("omnimate.cli.nodes:lss", "Find devices without a node id, and give them one (CiA 305)."),
    "conform": Verb(
        "omnimate.cli.conform:conform",
        "Check a device against CiA 301, 305, 402 and 406, and say what it does not do. It must not drive.",
    ),
    "dbc": Verb("omnimate.cli.dbc:dbc", "Write a DBC file with which other tools decode the same values."),
    "umbmark": Verb(
        "omnimate.cli.umbmark.verb:umbmark",
        "Calibrate wheelbase and wheel diameters from squares driven cw and ccw (UMBmark).",
    ),
    "calibrate": Verb(
        "omnimate.cli.calibrate.verb:calibrate",
        "Calibrate from any drive with absolute poses, by least squares; or a linkage from its own readings.",
    ),
    "drift": Verb(
        "omnimate.cli.drift:drift",
        "Say whether it is time to calibrate again: fine, calibrate again, or cannot tell.",
    ),
    "fleet": Verb(
        "omnimate.cli.fleet.verb:app",
        "Recordings of many robots: which robot is sick, which place of the floor is bad.",
    ),
    "design": Verb(
        "omnimate.cli.design:design",
        "Compare drives before driving: the Cramer-Rao bound of what each identifies.",
    ),
    "diagnose": Verb(
        "omnimate.cli.diagnose:diagnose",
        "Hold a simulation of the robot against recordings: where they differ, which physics is missing.",
    ),
    "serve": Verb(
        "omnimate.cli.serve:serve",
        "Serve calibration, recordings, diagnoses and fleets over REST, and a page for people, until Ctrl-C.",
    ),
    "import": Verb(
        "omnimate.cli.import_.verb:app",
        "Make recording folders from bus logs, CSV files or ROS bags.",
    ),
    "export": Verb(
        "omnimate.cli.export:export",
        "Write a recording or a log for Foxglove, PlotJuggler, ROS 2, evo, Wireshark, Vector or pandas.",
    ),
    "profile": Verb(
        "omnimate.cli.profile:app",
        "Parameters by name, for several floors or loads: list them, or put one into vehicle.toml.",
    ),
    "key": Verb("omnimate.cli.serve:keys", "API keys of the service: add, list, revoke."),
}


class VerbGroup(TyperGroup):
    """The command with all its verbs, of which only the one that is called is loaded."""

    def format_commands(self, ctx: Context, formatter: HelpFormatter) -> None:
        """Write the verbs, each with the whole of its line."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, VERBS[name].help) for name in self.list_commands(ctx)])

    def resolve_command(self, ctx: Context, args: list[str]) -> tuple[str | None, Command | None, list[str]]:
        """Return the verb that a call names, loaded, and the rest of the call."""
        name, command, rest = super().resolve_command(ctx, args)
        return name, command if name is None else load_verb(name), rest


def load_verb(name: str) -> Command:
    """Return a verb with its options."""
    module, attribute = VERBS[name].place.split(":")
    target = getattr(import_module(module), attribute)
    holder = typer.Typer(add_completion=False, rich_markup_mode=None)  # units in brackets are no markup
    if isinstance(target, typer.Typer):
        holder.add_typer(target, name=name)
    else:
        holder.command(name)(target)
    return typer.main.get_group(holder).commands[name]


def command() -> typer.Typer:
    """Return the command, which knows of every verb its name and one line of help."""
    app = typer.Typer(
        name="omnimate",
        cls=VerbGroup,
        help="Odometry that a robot fleet trusts: read, calibrate, simulate.",
        no_args_is_help=True,
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.callback()(_options)
    for name, verb in VERBS.items():
        app.command(name, help=verb.help)(_not_loaded)
    return app


def whole_command() -> TyperGroup:
    """Return the command with every verb loaded, for who reads the options of all."""
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
    """Stand for a verb in the list of all; `VerbGroup` loads the verb itself before it is called."""
