"""Who calls: API keys and their roles. On loopback, without any key, every caller may operate."""

from __future__ import annotations

import hashlib
import hmac
import secrets
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from sqlalchemy import select

from omnimate.service.errors import AuthenticationError
from omnimate.service.store.tables import KeyRow, find_row

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sqlalchemy.orm import Session

    from omnimate.service.store.database import Database

Role = Literal["read", "operate"]
PREFIX = "omk"
REMEMBERED_TIME = 1.0  # [s] before a key is looked up in the database again
REMEMBERED_CALLERS = 1000


@dataclass(frozen=True, slots=True)
class Caller:
    """Who calls: the id of a key, what it allows, and its name; "local" and None where no key is needed."""

    name: str
    role: Role
    key_name: str | None = None


LOCAL = Caller("local", "operate")


def add_key(db: Session, name: str, role: Role) -> str:
    """Add a key to the database and return it; only a hash of its secret is stored."""
    identity, secret = secrets.token_hex(4), secrets.token_urlsafe(32)
    db.add(KeyRow(id=identity, name=name, role=role, secret=_hash_of(secret), created=time.time()))
    return f"{PREFIX}_{identity}_{secret}"


def keys(db: Session) -> Sequence[KeyRow]:
    """Return all keys, oldest first."""
    return db.scalars(select(KeyRow).order_by(KeyRow.created)).all()


def revoke_key(db: Session, identity: str) -> KeyRow:
    """Make a key invalid; NotFoundError where there is no key with this id."""
    row = find_row(db, KeyRow, identity)
    row.revoked = row.revoked or time.time()
    return row


def caller_of(db: Session, authorization: str | None, *, keyless_allowed: bool) -> Caller:
    """Return who calls by an Authorization header; AuthenticationError without a valid key.

    Where `keyless_allowed`, no key is needed as long as the database has never held one.
    """
    if authorization is None:
        if keyless_allowed and db.scalar(select(KeyRow.id).limit(1)) is None:
            return LOCAL
        raise AuthenticationError(
            "this service needs a key: send Authorization: Bearer KEY (omnimate key add makes a key)"
        )
    scheme, _, key = authorization.partition(" ")
    prefix, _, rest = key.strip().partition("_")
    identity, _, secret = rest.partition("_")
    row = db.get(KeyRow, identity) if scheme.lower() == "bearer" and prefix == PREFIX else None
    if row is None or not hmac.compare_digest(row.secret, _hash_of(secret)):
        raise AuthenticationError(
            "the key is not known; expected Authorization: Bearer omk_..., as omnimate key add printed it"
        )
    if row.revoked is not None:
        raise AuthenticationError(f"key {row.name!r} has been revoked; ask for a new key")
    return Caller(row.id, "operate" if row.role == "operate" else "read", row.name)


class Callers:
    """The latest callers since the start; those of the last second need not be looked up in the database.

    A revoked key works for that long, and to stop the robot until its next other call.
    """

    def __init__(self, *, keyless_allowed: bool) -> None:
        self._keyless_allowed = keyless_allowed
        self._remembered: dict[str | None, tuple[Caller, float]] = {}

    def remembered(self, authorization: str | None, age: float) -> Caller | None:
        """Return who was identified by this Authorization header at most `age` [s] ago."""
        caller, at = self._remembered.get(authorization, (None, 0.0))
        return caller if time.monotonic() < at + age else None

    def identify(self, database: Database, authorization: str | None) -> Caller:
        """Return who calls, by the keys in the database, as `caller_of`."""
        try:
            with database.reading() as db:
                caller = caller_of(db, authorization, keyless_allowed=self._keyless_allowed)
        except AuthenticationError:
            self._remembered.pop(authorization, None)
            raise
        self._remembered.pop(authorization, None)  # to the end, behind those who called before
        self._remembered[authorization] = caller, time.monotonic()
        if len(self._remembered) > REMEMBERED_CALLERS:
            self._remembered.pop(next(iter(self._remembered)), None)
        return caller


def _hash_of(secret: str) -> str:
    return hashlib.sha256(secret.encode()).hexdigest()
