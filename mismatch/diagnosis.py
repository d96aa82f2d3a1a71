"""The result of `diagnose`: written as JSON by a fixed contract, and as a report for people.

Programs of other people read the JSON: fields are added, never removed or renamed.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import TYPE_CHECKING, Any, Literal, Self

if TYPE_CHECKING:
    from omnimate.effects.effect import Effect
    from omnimate.vehicle.se2 import Array

Verdict = Literal["agreement", "mismatch", "insufficient"]

Key = tuple[str, str]  # an effect, and the component on which it acts
# [1] factor by which noise levels of robots in use differ: exp(1.2), one standard deviation of the prior
# `LOG_LEVEL_SIGMA` of `noise.levels`.
USUAL_FACTOR = 3.3
DIFFERENT = 0.01  # [1] declared: of findings that are the same in all recordings, one in a hundred "differs"
ASSERTED = 0.5  # [1] probability from which a finding is asserted; below it is a possibility


def as_plain(value: Any) -> Any:  # noqa: ANN401  any value of JSON
    """Return a value as JSON has it: a dataclass as an object of its fields, a tuple as a list."""
    if is_dataclass(value):
        return {item.name: as_plain(getattr(value, item.name)) for item in fields(value)}
    if isinstance(value, dict):
        return {name: as_plain(item) for name, item in value.items()}
    if isinstance(value, tuple):
        return [as_plain(item) for item in value]
    return value


def _by_name(parameters: tuple[Parameter, ...]) -> dict[str, Any]:
    """Return the contract's object of parameters."""
    return {
        parameter.name: as_plain({"value": parameter.value, "sigma": parameter.sigma, "unit": parameter.unit})
        for parameter in parameters
    }


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter of an effect, as estimated."""

    name: str  # as in the vocabulary
    value: float | tuple[float, ...]  # a number, or one for each event
    sigma: float | tuple[float, ...]  # standard deviation of the estimate, likewise
    unit: str  # SI; "1" for a ratio


@dataclass(frozen=True, slots=True)
class Alternative:
    """Another effect that would explain what a finding explains."""

    effect: str
    component: str
    probability: float


@dataclass(frozen=True, slots=True)
class Where:
    """Where and when a mismatch is seen."""

    channels: tuple[str, ...] = ()  # channels on which it shows, strongest first
    # (start, end) on the recording's clock [s]; empty where it acts all the time
    intervals: tuple[tuple[float, float], ...] = ()
    regime: str = ""  # regime of the drive in which it shows, in words
    # numbers of the laps from 0, over all recordings in their order, in which it acts; empty for all
    laps: tuple[int, ...] = ()
    places: tuple[tuple[float, float], ...] = ()  # (x, y) on the floor [m] in the middle of each interval


@dataclass(frozen=True, slots=True)
class Repeats:
    """How a finding repeats in several recordings of a robot."""

    parameter: Parameter  # the finding's size, by each recording alone in their order
    # probability that estimates differ so much, or more, where all recordings have the same size
    p_value: float

    @property
    def agree(self) -> bool:
        """Whether the recordings agree on it, at the declared error rate `DIFFERENT`."""
        return self.p_value >= DIFFERENT


@dataclass(frozen=True, slots=True)
class Finding:
    """One piece of physics that the simulation leaves out.

    Attributes:
        effect: Name in the vocabulary, or "unknown".
        component: Component on which it acts.
        probability: Posterior probability of this effect on this component, among all that were considered.
        alternatives: Effects that the recording cannot distinguish from it, most probable first.
        where: Where and when it is seen.
        parameters: Parameters of its model.
        explained: Fraction of the mismatch's chi-square that it explains, 0 to 1.
        says: The finding in one sentence.
        depends_on: For "unknown", the quantities on which the residual depends.
        separates: A drive that would distinguish it from its alternatives; empty where there are none.
        repeats: Its size by each recording alone; None for one recording, and for what acts at moments.
    """

    effect: str
    component: str
    probability: float
    alternatives: tuple[Alternative, ...] = ()
    where: Where = field(default_factory=Where)
    parameters: tuple[Parameter, ...] = ()
    explained: float = 0.0
    says: str = ""
    depends_on: tuple[str, ...] = ()
    separates: str = ""
    repeats: Repeats | None = None

    @property
    def key(self) -> Key:
        """Effect and component."""
        return self.effect, self.component

    def as_json(self) -> dict[str, Any]:
        """Return the contract's object of a finding."""
        answer = {**as_plain(self), "parameters": _by_name(self.parameters)}
        if self.repeats is not None:
            answer["repeats"]["agree"] = self.repeats.agree
        depends_on = answer.pop("depends_on")
        return {**answer, "depends_on": depends_on} if self.effect == "unknown" else answer


@dataclass(frozen=True, slots=True)
class Calibrated:
    """Parameters that a recording with poses calibrates, whether or not they are a finding."""

    effect: str  # name in the vocabulary, or `reference_offset`, how the reference is mounted
    component: str  # component that it is of
    parameters: tuple[Parameter, ...]

    def as_json(self) -> dict[str, Any]:
        """Return the contract's object of a calibrated component."""
        return {**as_plain(self), "parameters": _by_name(self.parameters)}


@dataclass(frozen=True, slots=True)
class Change:
    """A normalised residual without and with the findings; 1.0 is the expected noise."""

    before: float
    after: float

    def undone(self) -> Self:
        """Return the residual with no finding applied."""
        return replace(self, after=self.before)


@dataclass(frozen=True, slots=True)
class Fit:
    """Residuals of simulation against recording, without and with the findings."""

    metric: str  # definition of the residuals, in words
    train: Change  # residual of the data that were fitted
    heldout: Change  # residual of laps or blocks to which no parameter was fitted
    channels: dict[str, Change] = field(default_factory=dict)  # held-out residual of each channel
    gain: tuple[float, float] = (0.0, 0.0)  # held-out decrease of half the chi-square, and its sigma
    # open-loop mismatch of each channel when the simulator runs over the held-out laps from the effects file
    # alone [m, rad]: without and with the effects
    rerun: dict[str, Change] = field(default_factory=dict)
    noise: dict[str, float] = field(default_factory=dict)  # noise levels used, by name, with unit in the name
    # noise levels of a nominal robot; of poses, 1 is what their file states
    usual_noise: dict[str, float] = field(default_factory=dict)

    @property
    def unusual_noise(self) -> tuple[str, ...]:
        """A phrase for each level that differs from its usual value by more than `USUAL_FACTOR`."""
        phrases = []
        for name, usual in self.usual_noise.items():
            ratio = self.noise.get(name, usual) / usual
            if 1.0 / USUAL_FACTOR < ratio < USUAL_FACTOR:
                continue
            what, _, unit = name.removesuffix("]").partition(" [")
            if unit == "1":
                phrases.append(f"{what} {ratio:.2g} times the sigma that the poses state")
            else:
                phrases.append(f"{what} {self.noise[name]:.2g} {unit}, {ratio:.2g} times the usual")
        return tuple(phrases)

    def unchanged(self) -> Self:
        """Return the fit of the robot as described, with no finding applied."""
        return replace(
            self,
            train=self.train.undone(),
            heldout=self.heldout.undone(),
            channels={name: change.undone() for name, change in self.channels.items()},
            gain=(0.0, 0.0),
            rerun={name: change.undone() for name, change in self.rerun.items()},
        )

    def as_json(self) -> dict[str, Any]:
        """Return the contract's object of a fit."""
        return {**as_plain(self), "gain": {"value": self.gain[0], "sigma": self.gain[1]}}


@dataclass(frozen=True, slots=True)
class Trace:
    """The mismatch of one recording over its windows, for plots."""

    recording: str  # name of the recording
    time: Array  # end of each window on the recording's clock, `(K,)` [s]
    path: Array  # positions of truck a, `(K, 2)` [m]
    lap: Array  # number of the lap, -1 between laps, `(K,)`
    before: Array  # whitened residual of each channel without the effects; nan where not read, `(K, C)`
    after: Array  # likewise with the effects, `(K, C)`


@dataclass(frozen=True, slots=True)
class Signature:
    """Signature of a finding: the mismatch against the quantity on which it depends, in bins."""

    finding: int  # number of the finding
    quantity: str  # label of the horizontal axis, with its unit as shown
    channel: str  # label of the vertical axis
    at: Array  # middle of each bin, `(B,)`
    measured: Array  # mean residual given all other findings, in standard deviations, `(B,)`
    sigma: Array  # its standard error, `(B,)`
    predicted: Array  # mean predicted by the effect's model, `(B,)`


@dataclass(frozen=True, slots=True)
class Evidence:
    """Data for the plots of a report; not part of the JSON."""

    channels: tuple[str, ...] = ()  # names of the columns of the traces
    traces: tuple[Trace, ...] = ()  # one trace for each recording
    signatures: tuple[Signature, ...] = ()
    # every effect and component considered, with the gain in log likelihood of adding it alone and its
    # probability of being in the right set, most probable first
    candidates: tuple[tuple[str, str, float, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """Diagnosis of recordings of one robot.

    Attributes:
        verdict: agreement, mismatch or insufficient.
        says: The verdict in a sentence; for "insufficient", what to record.
        findings: Findings, those that explain most first.
        fit: Residuals without and with the findings; None where there was nothing to compare with.
        unexplained: Fraction of the mismatch's chi-square that is left, 0 to 1.
        depends_on: Quantities on which the residual depends.
        robot: Name of the vehicle.
        recordings: Names of the recordings, in order.
        drive_next: Drives that would be informative, in words.
        evidence: Data for the plots of the report.
        effects: Findings and calibrated parameters as the simulator takes them, "unknown" excepted.
        calibrated: Effects in addition to the findings: parameters of robot and reference that are known
            more precisely than the file states them, without evidence that the file is wrong.
        traces: Effects that are present, but change the mismatch by less than a twentieth.
        complete: Whether the search converged before its time budget was used up.
    """

    verdict: Verdict
    says: str
    findings: tuple[Finding, ...] = ()
    fit: Fit | None = None
    unexplained: float = 0.0
    depends_on: tuple[str, ...] = ()
    robot: str = ""
    recordings: tuple[str, ...] = ()
    drive_next: tuple[str, ...] = ()
    evidence: Evidence = field(default_factory=Evidence)
    effects: tuple[Effect, ...] = ()
    calibrated: tuple[Calibrated, ...] = ()
    traces: tuple[Finding, ...] = ()
    complete: bool = True

    def as_json(self) -> dict[str, Any]:
        """Return the contract's object."""
        return {
            "verdict": self.verdict,
            "says": self.says,
            "robot": self.robot,
            "recordings": list(self.recordings),
            "findings": [finding.as_json() for finding in self.findings],
            "fit": None if self.fit is None else self.fit.as_json(),
            "unexplained": {"fraction": self.unexplained, "depends_on": list(self.depends_on)},
            "drive_next": list(self.drive_next),
            "calibrated": [calibrated.as_json() for calibrated in self.calibrated],
            "traces": [trace.as_json() for trace in self.traces],
            "complete": self.complete,
        }
