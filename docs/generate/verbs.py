"""The reference of every verb, from the parsers themselves."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from mkdocs.structure.files import File

from omnimate.cli.verbs import GROUPS, whole_command

if TYPE_CHECKING:
    from collections.abc import Iterator

    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files

NOTES = {
    "demo": "`--fault reboot:node=2,at=30` breaks a device on the way.",
    "record": "It finds the encoders, configures them by SDO, reads everything back, produces SYNC, and "
    "goes on when devices or the bus fail. `--listen-only` sends nothing.",
    "umbmark": "Begin with this one: it needs no reference but the place where each square begins and ends. "
    "It prints the paper's equations and the exact inversion side by side, each with its "
    "confidence interval, and advice where the numbers look wrong. "
    "[UMBmark](../explanation/umbmark.md) explains them.",
    "calibrate": "Take it instead of [`umbmark`](#umbmark) where something measures absolute poses all the "
    "way, such as motion capture or a lidar, or for the biases of a linkage. It prints parameters, their "
    "bounds, and what these drives do not identify. Poses may be dense, or at the stops.",
    "drift": "For a robot that is calibrated: it calibrates nothing.",
    "profile apply": "`umbmark` and `calibrate` write profiles with `--profile FILE NAME`.",
    "diagnose": "`--report` is for people, `--json` [for programs](diagnosis.md), `--effects-out` [for "
    "the simulator](effects.md). [The mismatch method](../explanation/mismatch.md) explains "
    "it.",
    "track": "Live or over a recording, with what was corrected and why: "
    "[IPEC](../explanation/ipec.md), [the filter](../explanation/filter.md).",
    "dump": "`-L` of candump byte for byte, or `-ta`. [My CAN log](../how-to/can-log.md) shows it.",
    "import csv": "[My CSV file](../how-to/csv-file.md) explains the mapping.",
    "import rosbag": "[My ROS bag](../how-to/ros-bag.md) shows it.",
    "monitor": "[Watch my bus](../how-to/monitor.md) shows it.",
    "import log": "[My other tools](../how-to/other-tools.md) shows it.",
    "export": "The suffix says the format: [My other tools](../how-to/other-tools.md).",
    "serve": "[My fleet](../how-to/fleet.md) shows it, "
    "[Run the service](../how-to/run-the-service.md) where it runs.",
    "fleet run": "[A fleet's daily run](../how-to/nights.md) shows it, with [its results](fleet-results.md).",
    "fleet report": "[The fleet model](../explanation/fleet.md) says how robots and places are separated.",
    "sim": "[My driver's tests](../how-to/driver-tests.md) shows it.",
}

GROUP_OF = {verb: group for group, verbs in GROUPS.items() for verb in verbs}

HEAD = """# Commands

`omnimate VERB --help` prints the same. Begin with `demo`, which needs no robot; with a robot, with `record`
and `umbmark`.

| command | what it does |
| --- | --- |
"""


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the page of all verbs."""
    files.append(File.generated(config, "reference/commands.md", content="".join(_page())))
    return files


def _page() -> Iterator[str]:
    group: Any = whole_command()
    verbs = list(_verbs(group, "omnimate"))
    unknown = NOTES.keys() - {name.removeprefix("omnimate ") for name, _ in verbs}
    if unknown:
        raise ValueError(f"notes on verbs that do not exist: {', '.join(sorted(unknown))}")
    yield HEAD
    group_before = ""
    for name, command in verbs:
        group_of_verb = GROUP_OF[name.split()[1]]
        if group_of_verb != group_before:
            group_before = group_of_verb
            yield f"| **{group_of_verb}** | |\n"
        text = _sentence(command.help or "")
        yield f"| [`{name}`](#{_anchor(name)}) | {_cell(text)} |\n"
    for name, command in verbs:
        yield f"\n## `{name}` {{ #{_anchor(name)} }}\n\n"
        yield from _verb(name, command)


def _verbs(group: Any, prefix: str) -> Iterator[tuple[str, Any]]:  # noqa: ANN401
    """Yield each verb with its whole name; those of a group one by one."""
    for name, command in group.commands.items():
        whole = f"{prefix} {name}"
        if hasattr(command, "commands"):
            yield from _verbs(command, whole)
        else:
            yield whole, command


def _verb(name: str, command: Any) -> Iterator[str]:  # noqa: ANN401
    arguments = [each for each in command.params if each.param_type_name == "argument"]
    options = [
        each
        for each in command.params
        if each.param_type_name == "option" and each.name != "help" and not each.hidden
    ]
    usage = " ".join([name, *(_metavar(each) for each in arguments), *(["[OPTIONS]"] if options else [])])
    note = NOTES.get(name.removeprefix("omnimate "), "")
    yield f"{command.help}\n\n{note}\n\n```text\n{usage}\n```\n\n"
    if arguments:
        yield "| argument | what it is |\n| --- | --- |\n"
        yield from (f"| `{_metavar(each)}` | {_cell(each.help or '')} |\n" for each in arguments)
        yield "\n"
    if options:
        yield "| option | what it is | default |\n| --- | --- | --- |\n"
        context = command.make_context(name, [], resilient_parsing=True)
        yield from (_option(each, context) for each in options)
        yield "\n"


def _option(option: Any, context: Any) -> str:  # noqa: ANN401
    names = ", ".join(f"`{name}`" for name in (*option.opts, *option.secondary_opts))
    kind = "" if option.is_flag else f" `{_kind(option, context)}`"
    repeated = " May be repeated." if option.multiple and "repeated" not in (option.help or "") else ""
    variable = f" Environment variable: `{option.envvar}`." if option.envvar else ""
    default = option.default
    shown = "" if default is None or default is False or default in ([], ()) else f"`{_value(default)}`"
    if option.required:
        shown = "required"
    return f"| {names}{kind} | {_cell(option.help or '')}{repeated}{variable} | {shown} |\n"


def _kind(option: Any, context: Any) -> str:  # noqa: ANN401
    """Return what an option takes, in the words of typer's own help, whose method was renamed in 0.29."""
    words = getattr(option, "display_type", None) or option.make_metavar
    kind = str(words(context)).partition(" [")[0].removeprefix("list[").strip("[]<>").replace(" range", "")
    return kind.replace("|", ", ") if "|" in kind else kind.upper()


def _value(value: object) -> str:
    return str(getattr(value, "value", value))


def _metavar(argument: Any) -> str:  # noqa: ANN401
    name = str(argument.name).rstrip("_").upper()
    if argument.nargs == -1:
        name += "..."
    return name if argument.required else f"[{name}]"


def _sentence(text: str) -> str:
    return text.strip().split("\n\n")[0].replace("\n", " ")


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|").replace("<", "&lt;")


def _anchor(name: str) -> str:
    return name.removeprefix("omnimate ").replace(" ", "-")
