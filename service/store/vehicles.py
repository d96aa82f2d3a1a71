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
    """Where the parameters of a version come from.

    Attributes:
        origin: The origin in words.
        made_by: The name of the key with which the version was made; None without a key.
        session: The id of the UMBmark session whose result it is; None for another origin.
    """

    origin: str
    made_by: str | None = None
    session: str | None = None


def newest(db: Session, name: str) -> VehicleRow:
    """Return the newest version of a vehicle.

    Raises:
        NotFoundError: there is no vehicle of this name.
    """
    row = db.scalars(_newest_first(name).limit(1)).first()
    if row is None:
        raise NotFoundError("vehicle", name)
    return row


def _newest_first(name: str) -> Select[VehicleRow]:
    return select(VehicleRow).where(VehicleRow.name == name).order_by(VehicleRow.version.desc())


def version(db: Session, name: str, number: int) -> VehicleRow:
    """Return one version of a vehicle.

    Raises:
        NotFoundError: there is no such version.
    """
    row = db.get(VehicleRow, (name, number))
    if row is None:
        raise NotFoundError(f"version of vehicle {name}:", str(number))
    return row


def versions(db: Session, name: str) -> Sequence[VehicleRow]:
    """Return all versions of a vehicle, newest first.

    Raises:
        NotFoundError: there is no vehicle of this name.
    """
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
    """Refuse a vehicle that could not be stored by its name; `where` says where it stands, for the message.

    Raises:
        InvalidValueError: the name is empty, too long, or holds a slash or a control character.
    """
    if re.fullmatch(NAME_PATTERN, vehicle.name) is None:
        raise InvalidValueError(where, f"{vehicle.name[:120]!r}; expected 1 to 100 characters, no slash")


def create(db: Session, vehicle: VehicleParameters, origin: Origin, text: str | None = None) -> VehicleRow:
    """Add the first version of a vehicle; `text` is its vehicle.toml as a person wrote it.

    Raises:
        StateError: there is a vehicle of this name already.
    """
    try:
        return _insert(db, vehicle, 1, origin, text)
    except IntegrityError as error:
        raise StateError(f"a vehicle {vehicle.name!r} exists already; PUT a new version of it") from error


def add_version(
    db: Session, vehicle: VehicleParameters, origin: Origin, expected: int | None, text: str | None = None
) -> VehicleRow:
    """Add a version of a vehicle, after every other transaction that adds one has ended.

    Args:
        db: The open transaction.
        vehicle: The parameters of the new version.
        origin: Where the parameters come from.
        expected: The version that the caller expects to be the newest; None accepts any version.
        text: Its vehicle.toml as a person wrote it; None where it is to be generated.

    Raises:
        NotFoundError: there is no vehicle of this name.
        ModifiedError: the newest version is not the expected one.
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
