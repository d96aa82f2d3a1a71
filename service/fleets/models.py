"""The bodies of requests and answers about fleets."""

from __future__ import annotations

from typing import Annotated, Literal
from urllib.parse import urlsplit

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, StringConstraints

from omnimate.fleet.batch.store import is_date
from omnimate.service.jobs.queue import JobState
from omnimate.service.umbmark.models import FiniteOrNull, RequestModel, RowModel

# Words of REST stay as published: `sick` is a faulty robot, `night` and `nights` are daily reports, `asked`
# are mismatches that triage repeats, `way` is the distance driven.
# Names are folders of a store, and parts of URLs: nothing in them is special to either.
PLAIN_PATTERN = r"^[A-Za-z0-9][A-Za-z0-9._-]*$"
MAX_NAME_LENGTH = 64
DAY_PATTERN = r"^[0-9]{4}-(0[1-9]|1[0-2])-(0[1-9]|[12][0-9]|3[01])$"
PlainName = Annotated[str, StringConstraints(min_length=1, max_length=MAX_NAME_LENGTH, pattern=PLAIN_PATTERN)]


def _require_date(day: str) -> str:
    """Return a day that the calendar has; the pattern also takes the 31st of February."""
    if not is_date(day):
        raise ValueError(f"{day!r}; expected a date of the calendar, YYYY-MM-DD")
    return day


Day = Annotated[
    str, Field(pattern=DAY_PATTERN, description="A date, YYYY-MM-DD."), AfterValidator(_require_date)
]
State = Literal["fine", "drift", "sick", "unjudged"]
Numbers = Annotated[list[float], BeforeValidator(list)]  # of an array, too
FindingState = Literal["open", "closed"]
DeliveryState = Literal["waiting", "accepted", "given up"]


class ExactModel(RequestModel):
    """A body that is taken as it is: a space around a name is an error."""

    model_config = ConfigDict(str_strip_whitespace=False)


class FleetStart(ExactModel):
    """A new fleet: robots that share floors, each of which has one frame of poses."""

    name: PlainName


class Fleet(BaseModel):
    """A fleet, and a summary of its latest daily report."""

    name: str
    created: float
    nights: int = Field(description="Number of daily reports.")
    night: str | None = Field(description="Date of the latest one.")
    states: dict[State, int] = Field(description="Robots by their state in it.")
    places: int = Field(description="Bad places of all floors in it.")


class Failure(BaseModel):
    """A recording that cannot be read or processed."""

    robot: str
    day: str
    recording: str
    problem: str


class Upload(BaseModel):
    """What of an upload was stored, and what was not."""

    recordings: int = Field(description="Recordings that were stored.")
    robots: list[str]
    days: list[str]
    refused: list[Failure] = Field(description="Recordings that cannot be read; they were not stored.")


class BatchStart(ExactModel):
    """The task of a batch."""

    day: Day | None = Field(None, description="Only recordings of this date; all by default.")
    diagnose: bool = Field(True, description="Whether whole diagnoses are made where triage asks for them.")
    priority: Annotated[int, Field(ge=-10, le=10, description="Higher ones first.")] = 0


class Batch(RowModel):
    """A batch that waits, is running, or has ended."""

    id: str
    kind: Literal["batch"] = "batch"
    fleet: str
    day: str | None
    diagnose: bool
    priority: int
    state: JobState
    progress: float
    doing: str
    done: int | None = Field(description="Recordings processed.")
    known: int | None = Field(description="Recordings whose results were known.")
    failures: list[Failure] = Field(description="The first 50 recordings without results.")
    night: str | None = Field(description="Date of the daily report at the end.")
    note: str | None = Field(description="Why there is no daily report.")
    error: str | None
    attempts: int
    created: float
    changed: float


class Change(RowModel):
    """The likeliest change in a robot's history; sizes are relative [1], or of a joint [rad]."""

    name: str
    since: str
    earliest: str
    latest: str
    shape: Literal["step", "ramp"]
    size: float
    sigma: float
    per_day: float
    log_e: float = Field(description="Logarithm of the e-value of any change.")
    share: float = Field(description="Probability of this number, given a change.")


class RobotAsked(RowModel):
    """A robot for which triage repeats the same mismatch."""

    robot: str
    effect: str
    component: str
    since: str


class FleetRobot(RowModel):
    """A robot of a fleet, as of a daily report."""

    robot: str
    kind: str | None
    state: State
    says: str | None = Field(
        description="The finding as a sentence, of a robot that is faulty (`sick`) or drifts."
    )
    change: Change | None = Field(description="The likeliest change, also of a robot that is fine.")
    asked: RobotAsked | None = Field(description="The mismatch that triage repeats, where `says` names it.")


class Place(RowModel):
    """A bad place of a floor."""

    floor: str = Field(description="Name of the floor; empty for the only one.")
    effect: Literal["loss", "creep"]
    says: str
    x: float
    y: float
    reach: float
    covariance: list[Numbers] = Field(description="Of x and y [m^2].")
    size: Numbers = Field(description="Part of the travel lost, or creep along x and y per metre.")
    per_crossing: float = Field(description="[m]")
    crossings: int


class RecordingFailed(BaseModel):
    """A recording of the day that has no results."""

    robot: str
    recording: str
    problem: str


class FloorAbout(RowModel):
    """One of a fleet's floors."""

    floor: str = Field(description="Its name, by `run.toml`; empty for the only one.")
    recordings: int = Field(description="Recordings on it within the week.")
    roughness: float = Field(description="Outside its bad places [m/sqrt(m)].")


class FleetNight(RowModel):
    """A daily report."""

    day: str
    recordings: int
    judged: int = Field(description="Robots with enough days to be judged.")
    roughness: float = Field(description="Of the first floor outside its bad places [m/sqrt(m)].")
    floors: list[FloorAbout] = Field(description="That with most recordings first.")
    sick: list[FleetRobot]
    places: list[Place]
    asked: list[RobotAsked]
    failed: list[RecordingFailed]


class FleetFloor(BaseModel):
    """A floor of a fleet, as of a daily report."""

    day: str
    floor: str
    cell: float = Field(description="Size of a cell [m].")
    driven: list[tuple[float, float, int]] = Field(
        description="x, y [m] of cells that were driven over, and the number of segments over each."
    )
    places: list[Place]


class FleetCourse(RowModel):
    """One number of a robot, day by day, without the effect of bad places."""

    name: str
    unit: Literal["1", "rad"]
    days: list[str]
    value: Numbers
    sigma: Numbers


class FleetHistory(BaseModel):
    """A robot's history."""

    robot: FleetRobot
    courses: list[FleetCourse]


class FleetRecording(BaseModel):
    """The results of one recording."""

    day: str
    recording: str
    duration: FiniteOrNull = Field(description="[s]")
    way: FiniteOrNull = Field(description="Distance driven [m].")
    triage: str | None
    says: str | None
    diagnosis: str | None = Field(description="The whole diagnosis in a sentence, where it was made.")
    problem: str | None


class Finding(RowModel):
    """A robot or a place that a daily report names."""

    id: str
    fleet: str
    kind: Literal["robot", "place"]
    state: FindingState
    robot: str | None
    what: str = Field(description="The robot's number, or the place's effect.")
    floor: str | None = Field(description="Of a place; empty for the only one.")
    x: float | None
    y: float | None
    says: str
    first: str = Field(description="Date of the first report that names it.")
    last: str = Field(description="Date of the last one.")
    created: float
    changed: float


def _require_receiver(url: str) -> str:
    """Return a URL to which a message can be sent."""
    try:
        parts = urlsplit(url)
        is_possible = bool(parts.hostname) and parts.port != 0 and url.isascii() and url.isprintable()
    except ValueError:  # brackets without an IPv6 address between them, or no such port
        is_possible = False
    if not is_possible:
        raise ValueError(
            "expected a URL such as https://host:8080/path, with a port from 1 to 65535, an IPv6 address in "
            "brackets, and %-codes for letters other than those of ASCII"
        )
    if "@" in parts.netloc:
        raise ValueError(
            "expected a URL without user and password, which everyone who may read would see; "
            "the secret of the webhook signs each message"
        )
    return url


class WebhookStart(ExactModel):
    """Where findings are sent."""

    url: Annotated[
        str, Field(max_length=1000, pattern=r"^https?://[^\s/]+\S*$"), AfterValidator(_require_receiver)
    ]


class Webhook(RowModel):
    """An address to which a fleet's findings are sent; the secret is shown when it is made, only."""

    id: str
    fleet: str
    url: str
    secret: str | None = None
    created: float


class Delivery(RowModel):
    """A message to a webhook."""

    id: str
    state: DeliveryState
    attempts: int
    due: float
    answer: str | None
    body: str
    created: float
    changed: float
