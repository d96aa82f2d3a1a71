"""The options that several verbs share; nothing is imported here that takes time."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Literal

import typer
from typer.models import OptionInfo

from omnimate.cli.errors import CallError


def check_out_file(path: Path | None) -> Path | None:
    """Return a file that a verb writes at its end; what takes minutes must have somewhere to go.

    Raises:
        CallError: It is a folder, or its folder is not there.
    """
    if path is not None and (path.is_dir() or not path.parent.is_dir()):
        problem = "it is a folder" if path.is_dir() else f"there is no folder {path.parent}"
        raise CallError(f"{path}: cannot be written: {problem}; choose another file")
    return path


def existing_log(text: str) -> Path:
    """Return the path of a log or of a recording folder, or `-` for standard input."""
    path = Path(text)
    if text != "-" and not path.exists():
        is_bus = f"; a bus is given as --bus {text}" if "://" in text else ""
        raise typer.BadParameter(f"Path '{text}' does not exist{is_bus}.")
    return path


def written_at_end(help_text: str, *names: str) -> OptionInfo:
    """Return the option of a file that a verb writes at its end."""
    option: OptionInfo = typer.Option(*names, callback=check_out_file, help=help_text)
    return option


def check_number(value: float | None) -> float | None:
    """Return a number; nan is none, and passes a range in some versions of typer."""
    if value is not None and math.isnan(value):
        raise typer.BadParameter("expected a number")
    return value


Protocol = Literal["umbmark", "straight", "rectangle", "free", "eight"]
MethodChoice = Literal["exact", "weighted", "heading", "printed"]
ExportFormat = Literal["ros2", "vda5050", "json"]
OneTruck = Annotated[
    Literal["a", "b"] | None, typer.Option(help="Calibrate this truck only; else each one that has poses.")
]

# A device on a bus.
Bus = Annotated[str, typer.Option(help="Bus of the device, such as socketcan://can0.")]
Node = Annotated[int, typer.Option(min=1, max=127, help="Its node id.")]
Eds = Annotated[Path | None, typer.Option(exists=True, help="EDS or DCF of the device, for names and types.")]
Timeout = Annotated[float, typer.Option(min=0.01, help="Time in which it answers [s].")]
Force = Annotated[bool, typer.Option("--force", help="Go on although another master sends SYNC.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON.")]

# A log, or a recording folder with one.
LogSource = Annotated[
    Path,
    typer.Argument(
        metavar="LOG", parser=existing_log, help="Log of any format, recording folder, or - for a pipe."
    ),
]
OptionalLogSource = Annotated[
    Path | None,
    typer.Argument(
        metavar="[LOG]", parser=existing_log, help="Log of any format, recording folder, or - for a pipe."
    ),
]

# What frames mean.
DbcFiles = Annotated[
    list[Path] | None, typer.Option(exists=True, help="DBC file whose signals to name; repeatable.")
]
EdsFiles = Annotated[
    list[str] | None, typer.Option(help="NODE=FILE: EDS or DCF whose objects to name; repeatable.")
]

# A robot on a bus.
VehicleFile = Annotated[
    Path | None, typer.Option(exists=True, help="vehicle.toml of the robot; else the reference robot.")
]
ListenOnly = Annotated[
    bool, typer.Option("--listen-only", help="Send nothing; another device must produce SYNC.")
]

# A simulated drive.
TrueVehicle = Annotated[
    Path | None,
    typer.Option(
        exists=True, help="vehicle.toml of the robot as it truly is; else with the errors of U Fig. 11."
    ),
]
Side = Annotated[
    float,
    typer.Option(
        help="Side of the square, or length of the path [m].", min=0.5, max=100.0, callback=check_number
    ),
]
Laps = Annotated[int, typer.Option(help="Laps in each direction, or free drives.", min=1, max=1000)]
Speed = Annotated[float, typer.Option(help="Speed of the wheels [m/s].", min=0.02, max=5.0)]
Bumps = Annotated[
    list[str] | None,
    typer.Option(help="Bump on the floor, such as wheel=a.right,after=3,height=0.01; may be repeated."),
]
Effects = Annotated[
    Path | None, typer.Option(exists=True, help="Effects file: physics that the nominal robot leaves out.")
]
Seed = Annotated[
    int, typer.Option(help="Seed of the floor, the sonar and the counters.", min=0, max=2**32 - 1)
]

# A calibration.
OutFile = Annotated[Path | None, written_at_end("Write the calibrated vehicle.toml here.", "--out")]
Profile = Annotated[
    tuple[Path, str] | None, typer.Option(help="FILE NAME: keep the result there under this name.")
]
