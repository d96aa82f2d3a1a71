"""`omnimate design`: which drive identifies which parameters how well, in a given space."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

from cli.calibrate_tables import designs_table
from cli.console import out
from cli.umbmark_tables import show


def design(
    length: Annotated[float, typer.Option(help="Of the free rectangle [m].", min=0.5)] = 14.0,
    width: Annotated[float, typer.Option(help="Of the free rectangle [m].", min=0.5)] = 4.0,
    metres: Annotated[float, typer.Option(help="That the wheels may roll [m].", min=1.0)] = 160.0,
    heading: Annotated[
        bool, typer.Option("--heading", help="Absolute headings can be measured, beside positions.")
    ] = False,
    heading_sigma: Annotated[
        float, typer.Option(help="How well [deg]; 0.02 is motion capture at rest, 0.4 the sonar of U.")
    ] = 0.02,
    roughness: Annotated[
        float, typer.Option(help="Of the floor [m/sqrt(m)]; 5.6e-4 scatters a 16 m square by 25 mm.")
    ] = 5.6e-4,
    vehicle: Annotated[
        Path | None, typer.Option(help="vehicle.toml of the robot; else that of U, 340 mm wide.", exists=True)
    ] = None,
) -> None:
    """Compare drives before driving: the Cramer-Rao bound of what each would tell."""
    from calib.design import Space, compare_designs
    from vehicle.file import load_vehicle
    from vehicle.parameters import Truck

    truck = Truck(0.340, 0.150, 0.150) if vehicle is None else load_vehicle(vehicle).trucks["a"]
    sigma = math.radians(heading_sigma) if heading else None
    designs = compare_designs(truck, Space(length, width, metres, sigma, roughness))
    show(designs_table(designs))
    for one in designs:
        for held in one.held:
            out.print(f"{one.name}: {held.name} is not identified; {held.reason}", soft_wrap=True)
    if not heading:
        out.print(
            "where absolute headings can be measured, open straights plus counted spins tell more: --heading",
            soft_wrap=True,
        )
