"""Vehicles and their versions in the database: each change adds a version, and the former ones stay."""

from __future__ import annotations

import re
from dataclasses import asdict, dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

from sqlalchemy import func, select
from sqlalchemy.exc import IntegrityError

from omnimate.service.errors import InvalidValueError, ModifiedError, NotFoundError, StateError
from omnimate.service.store.tables import VehicleRow
from omnimate.service.umbmark.models import NAME_PATTERN
from omnimate.vehicle.file import format_vehicle, parse_vehicle

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sqlalchemy import Select
    from sqlalchemy.orm import Session

    from omnimate.vehicle.parameters import VehicleParameters


@dataclass(frozen=True, slots=True)
class Origin:
    """Where the parameters of a version come from: in words, the name of a key, the id of a session."""

    origin: str
    made_by: str | None = None
    session: str | None = None


def newest(db: Session, name: str) -> VehicleRow:
    """Return the newest version of a vehicle; NotFoundError where there is no vehicle of this name."""
    row = db.scalars(_newest_first(name).limit(1)).first()
    if row is None:
        raise NotFoundError("vehicle", name)
    return row


def _newest_first(name: str) -> Select[VehicleRow]:
    return select(VehicleRow).where(VehicleRow.name == name).order_by(VehicleRow.version.desc())


def version(db: Session, name: str, number: int) -> VehicleRow:
    """Return one version of a vehicle; NotFoundError where there is no such version."""
    row = db.get(VehicleRow, (name, number))
    if row is None:
        raise NotFoundError(f"version of vehicle {name}:", str(number))
    return row


def versions(db: Session, name: str) -> Sequence[VehicleRow]:
    """Return all versions of a vehicle, newest first; NotFoundError where there is none."""
    rows = db.scalars(_newest_first(name)).all()
    if not rows:
        raise NotFoundError("vehicle", name)
    return rows


def newest_of_all(db: Session) -> Sequence[VehicleRow]:
    """Return the newest version of every vehicle, in the order of their names."""
    last = select(VehicleRow.name, func.max(VehicleRow.version).label("version")).group_by(VehicleRow.name)
    top = last.subquery()
    return db.scalars(
        select(VehicleRow)
        .join(top, (VehicleRow.name == top.c.name) & (VehicleRow.version == top.c.version))
        .order_by(VehicleRow.name)
    ).all()


def require_name(vehicle: VehicleParameters, where: str) -> None:
    """Refuse, by InvalidValueError about `where`, a vehicle that could not be stored by its name."""
    if re.fullmatch(NAME_PATTERN, vehicle.name) is None:
        raise InvalidValueError(where, f"{vehicle.name[:120]!r}; expected 1 to 100 characters, no slash")


def create(db: Session, vehicle: VehicleParameters, origin: Origin, text: str | None = None) -> VehicleRow:
    """Add the first version of a vehicle, as a person wrote its text; StateError where its name is taken."""
    try:
        return _insert(db, vehicle, 1, origin, text)
    except IntegrityError as error:
        raise StateError(f"a vehicle {vehicle.name!r} exists already; PUT a new version of it") from error


def add_version(
    db: Session, vehicle: VehicleParameters, origin: Origin, expected: int | None, text: str | None = None
) -> VehicleRow:
    """Add a version of a vehicle, after every other transaction that adds one has ended.

    NotFoundError where there is no such vehicle, ModifiedError where its newest version is not the expected
    one; None expects any. `text` is vehicle.toml as a person wrote it, None where it is to be generated.
    """
    db.get(VehicleRow, (vehicle.name, 1), with_for_update=True)
    last = newest(db, vehicle.name)
    if expected is not None and expected != last.version:
        raise ModifiedError(
            f"vehicle {vehicle.name!r} is at version {last.version}, not {expected}; "
            "look at what changed, then try again"
        )
    return _insert(db, vehicle, last.version + 1, origin, text)


def parameters_of(row: VehicleRow) -> VehicleParameters:
    """Return the vehicle parameters of a version."""
    return _parsed(row.toml, f"{row.name}, version {row.version}")


@lru_cache(maxsize=256)
def _parsed(toml: str, source: str) -> VehicleParameters:
    return parse_vehicle(toml, source)


def _insert(
    db: Session, vehicle: VehicleParameters, number: int, origin: Origin, text: str | None
) -> VehicleRow:
    toml = format_vehicle(vehicle) if text is None else text
    row = VehicleRow(name=vehicle.name, version=number, toml=toml, **asdict(origin))
    db.add(row)
    db.flush()
    return row
