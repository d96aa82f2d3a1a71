"""Vehicles and their versions: each change adds one, and the former ones stay."""

from __future__ import annotations

import time
from functools import lru_cache
from typing import TYPE_CHECKING

from sqlalchemy import func, select

from service.errors import ChangedError, NotThereError, StateError
from service.store.tables import VehicleRow
from vehicle.file import format_vehicle, parse_vehicle

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sqlalchemy.orm import Session

    from vehicle.parameters import VehicleParameters


def newest(db: Session, name: str) -> VehicleRow:
    """Return the newest version of a vehicle.

    Raises:
        NotThereError: there is none of the name.
    """
    row = db.scalars(
        select(VehicleRow).where(VehicleRow.name == name).order_by(VehicleRow.version.desc()).limit(1)
    ).first()
    if row is None:
        raise NotThereError("vehicle", name)
    return row


def version(db: Session, name: str, number: int) -> VehicleRow:
    """Return one version of a vehicle.

    Raises:
        NotThereError: there is no such version.
    """
    row = db.get(VehicleRow, (name, number))
    if row is None:
        raise NotThereError(f"version of vehicle {name}:", str(number))
    return row


def versions(db: Session, name: str) -> Sequence[VehicleRow]:
    """Return all versions of a vehicle, newest first.

    Raises:
        NotThereError: there is none of the name.
    """
    newest(db, name)
    return db.scalars(
        select(VehicleRow).where(VehicleRow.name == name).order_by(VehicleRow.version.desc())
    ).all()


def every(db: Session) -> Sequence[VehicleRow]:
    """Return the newest version of every vehicle, by name."""
    last = select(VehicleRow.name, func.max(VehicleRow.version).label("version")).group_by(VehicleRow.name)
    top = last.subquery()
    return db.scalars(
        select(VehicleRow)
        .join(top, (VehicleRow.name == top.c.name) & (VehicleRow.version == top.c.version))
        .order_by(VehicleRow.name)
    ).all()


def create(db: Session, vehicle: VehicleParameters, origin: str) -> VehicleRow:
    """Add the first version of a vehicle.

    Raises:
        StateError: the name is taken.
    """
    if db.get(VehicleRow, (vehicle.name, 1)) is not None:
        raise StateError(f"a vehicle {vehicle.name!r} is there already; PUT a new version of it")
    return _add(db, vehicle, 1, origin)


def replace(db: Session, vehicle: VehicleParameters, origin: str, expected: int | None) -> VehicleRow:
    """Add a version of a vehicle on top of the expected one (None: whichever is the newest).

    Raises:
        NotThereError: there is no vehicle of the name.
        ChangedError: the newest version is another one.
    """
    last = newest(db, vehicle.name)
    if expected is not None and expected != last.version:
        raise ChangedError(
            f"vehicle {vehicle.name!r} is at version {last.version}, not {expected}; "
            "look at what changed, then try again"
        )
    return _add(db, vehicle, last.version + 1, origin)


def parameters(row: VehicleRow) -> VehicleParameters:
    """Return the robot of a version."""
    return _parsed(row.toml, f"{row.name}, version {row.version}")


@lru_cache(maxsize=256)
def _parsed(toml: str, source: str) -> VehicleParameters:
    return parse_vehicle(toml, source)


def _add(db: Session, vehicle: VehicleParameters, number: int, origin: str) -> VehicleRow:
    row = VehicleRow(
        name=vehicle.name, version=number, toml=format_vehicle(vehicle), origin=origin, created=time.time()
    )
    db.add(row)
    db.flush()
    return row
