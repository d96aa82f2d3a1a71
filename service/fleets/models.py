"""The bodies of requests and answers about fleets."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, StringConstraints

from omnimate.service.jobs.queue import JobState
from omnimate.service.umbmark.models import RequestModel, RowModel

# Names are folders of a store, and parts of URLs: nothing in them is special to either.
PLAIN_PATTERN = r"^[A-Za-z0-9][A-Za-z0-9._-]*$"
DAY_PATTERN = r"^[0-9]{4}-(0[1-9]|1[0-2])-(0[1-9]|[12][0-9]|3[01])$"
PlainName = Annotated[str, StringConstraints(min_length=1, max_length=64, pattern=PLAIN_PATTERN)]
Day = Annotated[str, Field(pattern=DAY_PATTERN, description="A date, YYYY-MM-DD.")]
State = Literal["fine", "drift", "sick", "unjudged"]
FindingState = Literal["open", "closed"]
DeliveryState = Literal["waiting", "accepted", "given up"]


class ExactModel(RequestModel):
    """A body that is taken as it is: a space around a name, or `false` for 0, is an error."""

    model_config = ConfigDict(str_strip_whitespace=False, strict=True)


class FleetStart(ExactModel):
    """A new fleet: robots that share floors, each of which has one frame of poses."""

    name: PlainName


class Fleet(BaseModel):
    """A fleet, and what its last night showed."""

    name: str
    created: float
    nights: int = Field(description="Nights that were judged.")
    night: str | None = Field(description="Date of the last one.")
    states: dict[State, int] = Field(description="Robots by their state after the last night.")
    places: int = Field(description="Bad places of all floors after the last night.")


class Upload(BaseModel):
    """What an upload has stored."""

    recordings: int
    robots: list[str]
    days: list[str]


class BatchStart(ExactModel):
    """What a batch shall do."""

    day: Day | None = Field(None, description="Only recordings of this date; all by default.")
    diagnose: bool = Field(True, description="Whether whole diagnoses are made where triage asks for them.")
    priority: Annotated[int, Field(ge=-10, le=10, description="Higher ones first.")] = 0


class Failure(BaseModel):
    """A recording that a batch could not work on."""

    robot: str
    day: str
    recording: str
    problem: str


class Batch(BaseModel):
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
    done: int | None = Field(description="Recordings worked on.")
    known: int | None = Field(description="Recordings whose results were known.")
    failures: list[Failure] = Field(description="The first 50 recordings without results.")
    night: str | None = Field(description="Date of the night that was judged at the end.")
    note: str | None = Field(description="Why no night was judged.")
    error: str | None
    attempts: int
    created: float
    changed: float


class Change(RowModel):
    """What a robot's history shows; sizes are relative to vehicle.toml [1], or of a joint [rad]."""

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


class FleetRobot(BaseModel):
    """A robot of a fleet, as of a night."""

    robot: str
    kind: str | None
    state: State
    says: str | None = Field(description="The finding as a sentence, of a robot that is sick or drifts.")
    change: Change | None = Field(description="The likeliest change, also of a robot that is fine.")


class Place(BaseModel):
    """A bad place of a floor."""

    floor: str = Field(description="Name of the floor; empty for the only one.")
    effect: Literal["loss", "creep"]
    says: str
    x: float
    y: float
    reach: float
    covariance: list[list[float]] = Field(description="Of x and y [m^2].")
    size: list[float] = Field(description="Part of the travel lost, or creep along x and y per metre.")
    per_crossing: float = Field(description="[m]")
    crossings: int


class RobotAsked(RowModel):
    """A robot for which triage keeps asking for the same diagnosis."""

    robot: str
    effect: str
    component: str
    since: str


class RecordingFailed(BaseModel):
    """A recording of the night that has no results."""

    robot: str
    recording: str
    problem: str


class FloorAbout(RowModel):
    """One of a fleet's floors."""

    floor: str = Field(description="Its name, by `run.toml`; empty for the only one.")
    recordings: int = Field(description="Recordings on it within the week.")
    roughness: float = Field(description="Beside its bad places [m/sqrt(m)].")


class FleetNight(BaseModel):
    """The morning's list."""

    day: str
    recordings: int
    judged: int = Field(description="Robots with enough days to be judged.")
    roughness: float = Field(description="Of the first floor beside its bad places [m/sqrt(m)].")
    floors: list[FloorAbout] = Field(description="That with most recordings first.")
    sick: list[FleetRobot]
    places: list[Place]
    asked: list[RobotAsked]
    failed: list[RecordingFailed]


class FleetFloor(BaseModel):
    """A floor of a fleet, as of a night."""

    day: str
    floor: str
    cell: float = Field(description="Size of a cell [m].")
    driven: list[tuple[float, float, int]] = Field(
        description="x, y [m] of cells that were driven over, and ways over each."
    )
    places: list[Place]


class FleetCourse(BaseModel):
    """One number of a robot, day by day, without what bad places did."""

    name: str
    unit: Literal["1", "rad"]
    days: list[str]
    value: list[float]
    sigma: list[float]


class FleetHistory(BaseModel):
    """A robot's history."""

    robot: FleetRobot
    courses: list[FleetCourse]


class FleetRecording(BaseModel):
    """What a batch says of one recording."""

    day: str
    recording: str
    duration: float | None = Field(description="[s]")
    way: float | None = Field(description="[m]")
    triage: str | None
    says: str | None
    diagnosis: str | None = Field(description="What the whole diagnosis says, where it was made.")
    problem: str | None


class Finding(RowModel):
    """A robot or a place that a night's list names."""

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
    first: str = Field(description="Date of the first night that names it.")
    last: str = Field(description="Date of the last one.")
    created: float
    changed: float


class WebhookStart(ExactModel):
    """Where findings are sent."""

    url: Annotated[str, Field(max_length=1000, pattern=r"^https?://[^\s/]+\S*$")]


class Webhook(BaseModel):
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
