"""`omnimate profile`: the calibrations by name that `umbmark` and `calibrate` keep; list them, apply one."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from omnimate.cli.options import written_at_end
from omnimate.cli.robots import write_vehicle

app = typer.Typer(
    help="Parameters by name for several floors or loads: list, or put one into vehicle.toml.",
    no_args_is_help=True,
)


@app.command("list")
def list_profiles(
    file: Annotated[Path, typer.Argument(exists=True, help="File that --profile wrote.")],
) -> None:
    """Print the profiles of a file."""
    from omnimate.calib.profiles import load_profiles
    from omnimate.cli.tables import new_table, show

    table = new_table(str(file), ("profile", "truck"), ("wheelbase [mm]", "left [mm]", "right [mm]"))
    for name, profile in load_profiles(file).items():
        for truck, size in profile.items():
            numbers = (size.wheelbase, size.wheel_diameter_left, size.wheel_diameter_right)
            table.add_row(name, truck, *(f"{1e3 * number:.3f}" for number in numbers))
    show(table)


@app.command("apply")
def apply_profile(
    file: Annotated[Path, typer.Argument(exists=True, help="File that --profile wrote.")],
    name: Annotated[str, typer.Argument(help="Name of the profile.")],
    vehicle: Annotated[Path, typer.Option(exists=True, help="vehicle.toml of the robot.")],
    out_file: Annotated[
        Path,
        written_at_end("Write the vehicle.toml with this profile here.", "--out"),
    ],
) -> None:
    """Write a vehicle.toml whose trucks have the parameters of a profile; every verb then takes it."""
    from omnimate.calib.profiles import with_profile
    from omnimate.vehicle.file import load_vehicle

    write_vehicle(with_profile(load_vehicle(vehicle), file, name), out_file, f"profile {name}")
