"""`--config FILE.toml`: options of a command from a file, which the environment and the call override."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from omnimate.cli.errors import CallError
from omnimate.vehicle.errors import TableError
from omnimate.vehicle.tables import read_toml


def options_by_key(command: Any) -> dict[str, Any]:  # noqa: ANN401  # typer's types are private
    """Return the options that a file may set, by their keys in it: the long names without `--`."""
    options = {str(option.opts[0]).removeprefix("--"): option for option in command.params}
    return {key: option for key, option in options.items() if key not in {"config", "help"}}


def _read_defaults(context: typer.Context, file: Path | None) -> Path | None:
    """Take the values in a file as the defaults of a command's options."""
    if file is not None:
        try:
            context.default_map = dict(_default(context, *item) for item in read_toml(file).items())
        except TableError as error:
            raise CallError(f"{file}: {error}") from error
    return file


def _default(context: typer.Context, key: str, value: object) -> tuple[str, str]:
    """Return the name of an option and its value as text, as the environment would give it."""
    options = options_by_key(context.command)
    if key not in options:
        raise TableError(key, f"unknown key; expected one of {', '.join(options)}")
    if not isinstance(value, str | int | float):
        raise TableError(key, f"{value!r}; expected text or a number")
    try:
        options[key].process_value(context, str(value))
    except typer.BadParameter as error:
        raise TableError(key, f"{value!r}; {error.message}") from error
    return options[key].name, str(value)


ConfigFile = Annotated[
    Path | None,
    typer.Option(
        envvar="OMNIMATE_CONFIG",
        is_eager=True,
        callback=_read_defaults,
        exists=True,
        dir_okay=False,
        help="TOML file with these options; the environment and the call override it.",
    ),
]
