"""`omnimate design`: which drive identifies which parameters how well, in a given space."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from omnimate.cli.console import say
from omnimate.cli.options import check_number
from omnimate.cli.tables import new_table, show
from omnimate.vehicle.floor import CONCRETE_ROUGHNESS

if TYPE_CHECKING:
    from rich.table import Table

    from omnimate.calib.paths.design import Design


def design(
    length: Annotated[
        float,
        typer.Option(help="Length of the free rectangle [m].", min=0.5, max=100.0, callback=check_number),
    ] = 14.0,
    width: Annotated[
        float,
        typer.Option(help="Width of the free rectangle [m].", min=0.5, max=100.0, callback=check_number),
    ] = 4.0,
    metres: Annotated[
        float,
        typer.Option(help="How far the wheels may roll [m].", min=1.0, max=1000.0, callback=check_number),
    ] = 160.0,
    heading: Annotated[
        bool, typer.Option("--heading", help="Absolute headings can be measured, in addition to positions.")
    ] = False,
    heading_sigma: Annotated[
        float,
        typer.Option(
            help="Standard deviation of a heading [deg]; motion capture at rest has 0.02.",
            min=1e-4,
            max=45.0,
            callback=check_number,
        ),
    ] = 0.02,
    roughness: Annotated[
        float,
        typer.Option(help="Roughness of the floor [m/sqrt(m)]; 5.6e-4 scatters a 16 m square by 25 mm."),
    ] = CONCRETE_ROUGHNESS,
    vehicle: Annotated[
        Path | None, typer.Option(help="vehicle.toml of the robot; else that of U, 340 mm wide.", exists=True)
    ] = None,
) -> None:
    """Compare drives before driving: the Cramer-Rao bound of what each identifies."""
    from omnimate.calib.paths.design import Space, compare_designs
    from omnimate.vehicle.file import load_vehicle
    from omnimate.vehicle.parameters import Truck

    truck = Truck(0.340, 0.150, 0.150) if vehicle is None else load_vehicle(vehicle).trucks["a"]
    sigma = math.radians(heading_sigma) if heading else None
    designs = compare_designs(truck, Space(length, width, metres, sigma, roughness))
    show(designs_table(designs))
    for candidate in designs:
        for held in candidate.held:
            say(f"{candidate.name}: {held.name} is not identified; {held.reason}")
    if not heading:
        say("where headings can be measured, open straights plus counted spins say more: give --heading")


def designs_table(designs: Sequence[Design]) -> Table:
    """Return the candidate drives: bounds before any drive, and what they leave on a square."""
    heads = (
        "drives",
        "wheels\nroll [m]",
        "wheelbase\n[%]",
        "E_s\n[%]",
        "E_d\n[%]",
        "left on a 4 m\nsquare [mm]",
    )
    table = new_table("Cramer-Rao bound of each drive, one sigma", ("drive",), heads)
    for candidate in designs:
        bounds = ("-" if math.isnan(sigma) else f"{1e2 * sigma:.4f}" for sigma in candidate.sigma)
        left = (
            "not known" if math.isnan(candidate.residual_error) else f"{1e3 * candidate.residual_error:.1f}"
        )
        table.add_row(candidate.name, str(candidate.laps), f"{candidate.travel:.0f}", *bounds, left)
    return table
