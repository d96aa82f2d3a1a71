"""`omnimate dbc`: a vehicle's PDOs for cantools, SavvyCAN and other tools."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from omnimate.cli.console import err
from omnimate.files.logs.dbc import format_dbc
from omnimate.vehicle.atomic import write_text
from omnimate.vehicle.file import load_vehicle


def dbc(
    vehicle: Annotated[Path, typer.Argument(help="vehicle.toml of the robot.")],
    out_file: Annotated[Path, typer.Argument(metavar="OUT.dbc", help="DBC file to write.")],
) -> None:
    """Write a DBC file with which other tools decode the same values."""
    write_text(out_file, format_dbc(load_vehicle(vehicle)))
    err.print(f"written: {out_file}", markup=False)
