"""A session's result: read, and accepted as the vehicle's newest version."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from omnimate.calib.apply import corrected_vehicle
from omnimate.service.errors import ModifiedError, StateError
from omnimate.service.store import vehicles
from omnimate.service.umbmark.models import Result
from omnimate.service.umbmark.sessions import possible_calls, samples_of
from omnimate.vehicle.parameters import Truck

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sqlalchemy.orm import Session as Db

    from omnimate.service.store.tables import SessionRow, VehicleRow
    from omnimate.service.umbmark.models import Sample
    from omnimate.vehicle.parameters import VehicleParameters


def store_result(db: Db, row: SessionRow, samples: Sequence[Sample], result: Result) -> None:
    """Make a result that was calculated from some runs that of their session.

    Raises:
        StateError: the session has other runs now.
    """
    if samples_of(db, row) != samples:
        raise StateError(
            f"the runs of session {row.id} changed while it was solved; solve it again",
            possible_calls(row, time.time()),
        )
    row.state, row.result, row.detail = "solved", result.model_dump_json(), ""


def last_result(row: SessionRow) -> Result:
    """Return the result of the last solve.

    Raises:
        StateError: the session has no result.
    """
    if row.result is None:
        raise StateError(f"session {row.id} has no result", possible_calls(row, time.time()))
    return Result.model_validate_json(row.result)


def accept_result(db: Db, row: SessionRow, revision: str | None, *, force: bool) -> VehicleRow:
    """Make a session's result the newest version of its vehicle.

    The revision is the one that the caller has seen, None for any; `force` accepts a result of which a check
    reports an error.

    Raises:
        ModifiedError: the result has another revision, or the vehicle has a newer version.
        StateError: a check of the result reports an error, and `force` is not set.
    """
    result = last_result(row)
    if revision is not None and revision != result.revision:
        raise ModifiedError(
            f"the result has the revision {result.revision}, not {revision}; get the result again"
        )
    if not result.usable and not force:
        raise StateError("a check of this result reports an error (see advice); send force to use it anyway")
    trucks = {name: Truck(**truck.calibrated.model_dump()) for name, truck in result.trucks.items()}
    vehicle = corrected_vehicle(vehicle_of(db, row), trucks)
    version = vehicles.add_version(db, vehicle, f"session {row.id}", row.vehicle_version)
    row.state, row.detail = "accepted", f"vehicle {row.vehicle} is now at version {version.version}"
    return version


def vehicle_of(db: Db, row: SessionRow) -> VehicleParameters:
    """Return the parameters of the vehicle that the session calibrates."""
    return vehicles.parameters_of(vehicles.version(db, row.vehicle, row.vehicle_version))
