"""The tables, and how their rows are found and listed.

Times are seconds since 1970; JSON is stored as text, alike in both databases.
"""

from __future__ import annotations

import re
import secrets
import time
from typing import TYPE_CHECKING, Any, TypeVar

from pydantic import TypeAdapter
from sqlalchemy import (
    Dialect,
    Double,
    ForeignKey,
    Index,
    LargeBinary,
    String,
    Text,
    TypeDecorator,
    select,
    tuple_,
)
from sqlalchemy.orm import DeclarativeBase, Mapped, mapped_column

from omnimate.service.errors import InvalidValueError, NotFoundError
from omnimate.service.umbmark.models import ReturnError
from omnimate.vehicle.parameters import TruckName

if TYPE_CHECKING:
    from sqlalchemy import ColumnElement
    from sqlalchemy.orm import InstrumentedAttribute, Session


def _now() -> float:
    return time.time()


class JsonText(TypeDecorator[Any]):
    """A value of a type as JSON; it is replaced as a whole and never changed in place."""

    impl = Text
    cache_ok = True

    def __init__(self, form: Any = Any) -> None:  # noqa: ANN401  # any type that pydantic knows
        super().__init__()
        self.form = form
        self._adapter: TypeAdapter[Any] = TypeAdapter(form)

    def process_bind_param(self, value: Any, dialect: Dialect) -> str | None:  # noqa: ANN401, ARG002
        """Return the text of a value; None stays NULL."""
        return None if value is None else self._adapter.dump_json(value).decode()

    def process_result_value(self, value: str | None, dialect: Dialect) -> Any:  # noqa: ANN401, ARG002
        """Return the value of a text."""
        return None if value is None else self._adapter.validate_json(value)


class Base(DeclarativeBase):
    """All tables."""

    type_annotation_map = {float: Double}  # noqa: RUF012  # SQLAlchemy's own form


class ListedRow(Base):
    """A row of a list that is read by age."""

    __abstract__ = True
    id: Mapped[str] = mapped_column(String(32), primary_key=True, default=lambda: secrets.token_hex(8))
    created: Mapped[float] = mapped_column(default=_now)

    @classmethod
    def noun(cls) -> str:
        """Return what a row is, in a word for messages."""
        return cls.__name__.removesuffix("Row").lower()


class VehicleRow(Base):
    """One version of a vehicle's parameters; versions are added and never changed."""

    __tablename__ = "vehicles"
    name: Mapped[str] = mapped_column(String(100), primary_key=True)
    version: Mapped[int] = mapped_column(primary_key=True)
    toml: Mapped[str] = mapped_column(Text)
    origin: Mapped[str] = mapped_column(String(200))
    session: Mapped[str | None] = mapped_column(String(32))  # whose result it is
    made_by: Mapped[str | None] = mapped_column(String(100))  # name of the key that made it
    created: Mapped[float] = mapped_column(default=_now)


class SessionRow(ListedRow):
    """A UMBmark session; `revision` counts its changes, and refuses a second simultaneous one."""

    __tablename__ = "sessions"
    __table_args__ = (Index("sessions_by_age", "created", "id"), Index("sessions_by_state", "state"))
    vehicle: Mapped[str] = mapped_column(String(100))
    vehicle_version: Mapped[int]
    side: Mapped[float]
    runs: Mapped[int]
    how: Mapped[str] = mapped_column(String(20))
    speed: Mapped[float]
    lifeline: Mapped[float | None]
    state: Mapped[str] = mapped_column(String(20), default="collecting")
    detail: Mapped[str] = mapped_column(String(1000), default="")
    changed: Mapped[float] = mapped_column(default=_now)
    expires: Mapped[float]
    revision: Mapped[int] = mapped_column(default=1)
    result: Mapped[str | None] = mapped_column(Text)
    pending: Mapped[dict[str, Any] | None] = mapped_column(JsonText)  # a lap that is driven, not yet measured
    owner: Mapped[str | None] = mapped_column(String(32))  # instance of the service that drives for it
    lease: Mapped[float | None]  # time at which its ownership ends unless it is renewed
    __mapper_args__ = {"version_id_col": revision}  # noqa: RUF012  # SQLAlchemy's own form


class SampleRow(Base):
    """One run of a session: the return error of each truck."""

    __tablename__ = "samples"
    session: Mapped[str] = mapped_column(ForeignKey("sessions.id"), primary_key=True)
    number: Mapped[int] = mapped_column(primary_key=True)
    direction: Mapped[str] = mapped_column(String(3))
    errors: Mapped[dict[TruckName, ReturnError]] = mapped_column(JsonText(dict[TruckName, ReturnError]))
    source: Mapped[str] = mapped_column(String(200))
    recording: Mapped[str | None] = mapped_column(String(32))
    created: Mapped[float]


class RecordingRow(ListedRow):
    """A recording folder; its zip is a file of `omnimate.service.store.recordings`."""

    __tablename__ = "recordings"
    __table_args__ = (Index("recordings_by_age", "created", "id"),)
    name: Mapped[str] = mapped_column(String(200))
    vehicle: Mapped[str] = mapped_column(String(100))
    samples: Mapped[int]
    seconds: Mapped[float]
    laps: Mapped[int]
    poses: Mapped[int]
    size: Mapped[int]
    sha256: Mapped[str | None] = mapped_column(String(64))  # of the zip; None for one of an earlier version
    problems: Mapped[list[str] | None] = mapped_column(JsonText(list[str]))  # of the log; None as above


class RecordingFileRow(Base):
    """A file to be written or deleted; a day later it is deleted where no recording has its id."""

    __tablename__ = "recording_files"
    id: Mapped[str] = mapped_column(String(32), primary_key=True)
    created: Mapped[float]


class RecordingContentRow(Base):
    """The zip of a recording of an earlier version, until the next start makes it a file."""

    __tablename__ = "recording_contents"
    id: Mapped[str] = mapped_column(String(32), primary_key=True)
    content: Mapped[bytes] = mapped_column(LargeBinary)


class JobRow(ListedRow):
    """A diagnosis, or a batch of a fleet; at the time `lease` its owner is considered dead."""

    __tablename__ = "jobs"
    __table_args__ = (
        Index("jobs_by_age", "created", "id"),
        Index("jobs_by_state", "state"),
        Index("jobs_by_content", "content"),
    )
    __mapper_args__ = {"polymorphic_on": "kind"}  # noqa: RUF012  # SQLAlchemy's own form
    kind: Mapped[str] = mapped_column(String(20))
    fleet: Mapped[str | None] = mapped_column(String(64))
    asked: Mapped[dict[str, Any] | None] = mapped_column(JsonText)  # what a batch shall do
    summary: Mapped[dict[str, Any] | None] = mapped_column(JsonText)  # what a batch did
    priority: Mapped[int] = mapped_column(default=0)  # higher ones first
    recordings: Mapped[list[str]] = mapped_column(JsonText)
    caller: Mapped[str | None] = mapped_column(String(16))  # id of the key that asked for it
    content: Mapped[str | None] = mapped_column(String(64))  # hash of all that its result depends on
    state: Mapped[str] = mapped_column(String(20), default="queued")
    progress: Mapped[float] = mapped_column(default=0.0)
    doing: Mapped[str] = mapped_column(String(200), default="waiting")
    verdict: Mapped[str | None] = mapped_column(String(20))
    says: Mapped[str | None] = mapped_column(Text)
    error: Mapped[str | None] = mapped_column(Text)
    attempts: Mapped[int] = mapped_column(default=0)
    changed: Mapped[float] = mapped_column(default=_now)
    owner: Mapped[str | None] = mapped_column(String(32))
    lease: Mapped[float | None]
    result: Mapped[str | None] = mapped_column(Text, deferred=True)
    report: Mapped[str | None] = mapped_column(Text, deferred=True)


class DiagnosisRow(JobRow):
    """A diagnosis among the jobs."""

    __mapper_args__ = {"polymorphic_identity": "diagnose"}  # noqa: RUF012


class BatchRow(JobRow):
    """A batch among the jobs."""

    __mapper_args__ = {"polymorphic_identity": "batch"}  # noqa: RUF012


class KeyRow(ListedRow):
    """An API key; only a hash of its secret is stored."""

    __tablename__ = "keys"
    id: Mapped[str] = mapped_column(String(16), primary_key=True)
    name: Mapped[str] = mapped_column(String(100))
    role: Mapped[str] = mapped_column(String(20))
    secret: Mapped[str] = mapped_column(String(64))
    revoked: Mapped[float | None]


class AnswerRow(Base):
    """The answer to a request with an Idempotency-Key, given again when the request is repeated."""

    __tablename__ = "answers"
    __table_args__ = (Index("answers_by_age", "created"),)
    caller: Mapped[str] = mapped_column(String(16), primary_key=True)
    key: Mapped[str] = mapped_column(String(200), primary_key=True)
    call: Mapped[str] = mapped_column(String(400))
    digest: Mapped[str] = mapped_column(String(64))
    status: Mapped[int] = mapped_column(default=0)
    headers: Mapped[dict[str, str]] = mapped_column(JsonText, default=dict)
    body: Mapped[str] = mapped_column(Text, default="")
    created: Mapped[float] = mapped_column(default=_now)


class FleetRow(ListedRow):
    """A fleet: robots that share floors. Its recordings and results are files."""

    __tablename__ = "fleets"
    __table_args__ = (Index("fleets_by_age", "created", "id"),)
    id: Mapped[str] = mapped_column(String(64), primary_key=True)  # its name
    night: Mapped[str | None] = mapped_column(String(10))  # of the latest report whose findings were noted


class FindingRow(ListedRow):
    """A robot or a place that a daily report names; open until a later one does not name it."""

    __tablename__ = "findings"
    __table_args__ = (Index("findings_by_age", "created", "id"), Index("findings_by_fleet", "fleet", "state"))
    fleet: Mapped[str] = mapped_column(ForeignKey("fleets.id"))
    kind: Mapped[str] = mapped_column(String(20))
    state: Mapped[str] = mapped_column(String(20), default="open")
    robot: Mapped[str | None] = mapped_column(String(100))
    what: Mapped[str] = mapped_column(String(40))
    floor: Mapped[str | None] = mapped_column(String(64))  # of a place; empty for the only one
    x: Mapped[float | None]
    y: Mapped[float | None]
    says: Mapped[str] = mapped_column(Text)
    first: Mapped[str] = mapped_column(String(10))
    last: Mapped[str] = mapped_column(String(10))
    changed: Mapped[float] = mapped_column(default=_now)


class WebhookRow(ListedRow):
    """An address to which a fleet's findings are sent."""

    __tablename__ = "webhooks"
    __table_args__ = (Index("webhooks_by_age", "created", "id"),)
    fleet: Mapped[str] = mapped_column(ForeignKey("fleets.id"))
    url: Mapped[str] = mapped_column(String(1000))
    secret: Mapped[str] = mapped_column(String(100))


class DeliveryRow(ListedRow):
    """A message to a webhook, written in the transaction of its finding, and sent until it is accepted."""

    __tablename__ = "deliveries"
    __table_args__ = (Index("deliveries_by_age", "created", "id"), Index("deliveries_due", "state", "due"))
    id: Mapped[str] = mapped_column(
        String(40), primary_key=True, default=lambda: f"msg_{secrets.token_hex(12)}"
    )
    webhook: Mapped[str] = mapped_column(String(32))  # without a key: a message outlives its webhook
    body: Mapped[str] = mapped_column(Text)
    state: Mapped[str] = mapped_column(String(20), default="waiting")
    attempts: Mapped[int] = mapped_column(default=0)
    due: Mapped[float] = mapped_column(default=_now)
    answer: Mapped[str | None] = mapped_column(String(200))
    changed: Mapped[float] = mapped_column(default=_now)


Row = TypeVar("Row", bound=ListedRow)


def lease_ended(
    lease: InstrumentedAttribute[float | None], now: float, duration: float
) -> ColumnElement[bool]:
    """Return whether a lease of a duration [s] is over, by the wall clock of the service that asks.

    One that ends later than a lease can was taken before the clock was set back. Clocks of services may
    differ by a duration.
    """
    return (lease < now) | (lease > now + 2.0 * duration)


def find_row(db: Session, table: type[Row], key: str, *, for_change: bool = False, **having: object) -> Row:
    """Return the row of a table with a key and the values that it is `having`; NotFoundError without it.

    `for_change` locks it until the end of the transaction.
    """
    row = db.get(table, key, with_for_update=for_change)
    if row is None or any(getattr(row, name) != value for name, value in having.items()):
        raise NotFoundError(table.noun(), key)
    return row


CURSOR_PATTERN = r"^[0-9]+(\.[0-9]+)?(e[+-]?[0-9]+)?_[0-9A-Za-z._-]{1,64}$"


def read_page(
    db: Session, table: type[Row], limit: int, after: str | None, *where: ColumnElement[bool]
) -> tuple[list[Row], str | None]:
    """Return a page of rows and the cursor of the next page, which is None after the last one.

    `after` is the cursor, None for the first page; InvalidValueError where it is none. It is the time and the
    id of the row before the page, so that it holds also when that row is deleted.
    """
    query = select(table).where(*where).order_by(table.created.desc(), table.id.desc()).limit(limit + 1)
    if after is not None:
        if re.fullmatch(CURSOR_PATTERN, after) is None:
            raise InvalidValueError("query.after", "no cursor; expected the `next` of the page before")
        created, _, identity = after.partition("_")
        query = query.where(tuple_(table.created, table.id) < tuple_(float(created), identity))
    rows = list(db.scalars(query))
    last = rows[limit - 1] if len(rows) > limit else None
    return rows[:limit], None if last is None else f"{last.created!r}_{last.id}"
