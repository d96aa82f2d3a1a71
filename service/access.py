"""Who calls: keys and their roles. On loopback without keys everybody may operate."""

from __future__ import annotations

import hashlib
import hmac
import secrets
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from sqlalchemy import select

from service.errors import KeyProblem, NotThereError, RoleProblem
from service.store.tables import KeyRow

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sqlalchemy.orm import Session

    from service.store.database import Database

Role = Literal["read", "operate"]
PREFIX = "omk"
TRUSTED = 1.0  # [s] without a look into the database
REMEMBERED = 1000  # callers


@dataclass(frozen=True, slots=True)
class Caller:
    """Who calls.

    Attributes:
        name: id of the key; "local" where none is needed.
        role: what may be done.
    """

    name: str
    role: Role


LOCAL = Caller("local", "operate")


def add_key(db: Session, name: str, role: Role) -> str:
    """Make a key and return it; only the hash of its secret is kept."""
    identity, secret = secrets.token_hex(4), secrets.token_urlsafe(32)
    db.add(KeyRow(id=identity, name=name, role=role, secret=_hash(secret), created=time.time()))
    return f"{PREFIX}_{identity}_{secret}"


def keys(db: Session) -> Sequence[KeyRow]:
    """Return all keys, the oldest first."""
    return db.scalars(select(KeyRow).order_by(KeyRow.created)).all()


def revoke_key(db: Session, identity: str) -> KeyRow:
    """Make a key void.

    Raises:
        NotThereError: there is none of this id.
    """
    row = db.get(KeyRow, identity)
    if row is None:
        raise NotThereError("key", identity)
    row.revoked = row.revoked or time.time()
    return row


def caller_of(db: Session, authorization: str | None, *, open_house: bool) -> Caller:
    """Return who calls.

    Args:
        db: holds the keys.
        authorization: header of the call.
        open_house: whether no key is needed as long as there has never been one.

    Raises:
        KeyProblem: no key, or a wrong one.
    """
    if authorization is None:
        if open_house and db.scalar(select(KeyRow.id).limit(1)) is None:
            return LOCAL
        raise KeyProblem(
            "this service asks for a key: send Authorization: Bearer KEY (omnimate key add makes one)"
        )
    scheme, _, key = authorization.partition(" ")
    prefix, _, rest = key.strip().partition("_")
    identity, _, secret = rest.partition("_")
    row = db.get(KeyRow, identity) if scheme.lower() == "bearer" and prefix == PREFIX else None
    if row is None or not hmac.compare_digest(row.secret, _hash(secret)):
        raise KeyProblem(
            "the key is not known; expected Authorization: Bearer omk_..., as omnimate key add said"
        )
    if row.revoked is not None:
        raise KeyProblem(f"key {row.name!r} has been revoked; ask for a new one")
    return Caller(row.id, "operate" if row.role == "operate" else "read")


class Callers:
    """Who called lately: a key is looked up again after a second, for which a revoked one still opens."""

    def __init__(self, *, open_house: bool) -> None:
        self._open_house = open_house
        self._known: dict[str | None, tuple[Caller, float]] = {}

    def known(self, authorization: str | None) -> Caller | None:
        """Return who called with this header within the last second."""
        caller, until = self._known.get(authorization, (None, 0.0))
        return caller if time.monotonic() < until else None

    def look(self, database: Database, authorization: str | None) -> Caller:
        """Return who calls.

        Raises:
            KeyProblem: no key, or a wrong one.
        """
        with database.reading() as db:
            caller = caller_of(db, authorization, open_house=self._open_house)
        if len(self._known) > REMEMBERED:
            self._known.clear()
        self._known[authorization] = caller, time.monotonic() + TRUSTED
        return caller


def demand(caller: Caller, role: Role) -> None:
    """Refuse a caller who may not do this.

    Raises:
        RoleProblem: the key is one for reading.
    """
    if role == "operate" and caller.role != "operate":
        raise RoleProblem(
            "this key may only read; moving the robot or changing anything needs the role operate"
        )


def _hash(secret: str) -> str:
    return hashlib.sha256(secret.encode()).hexdigest()
