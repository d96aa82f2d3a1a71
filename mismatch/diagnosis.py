"""What `diagnose` answers: one object, written as JSON by a fixed contract and as a report for people.

The JSON is read by other people's programs; fields are added, never taken away or renamed.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal, Self

if TYPE_CHECKING:
    from omnimate.effects.effect import Effect
    from omnimate.vehicle.se2 import Array

Verdict = Literal["agreement", "mismatch", "insufficient"]

Key = tuple[str, str]  # an effect, and the component on which it acts
# By which levels of noise of robots in use differ: one standard deviation of the prior in `noise.levels`.
USUAL_FACTOR = 3.3
ASSERTED = 0.5  # a finding of this probability or more is an assertion, one of less a possibility


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter of an effect, as estimated.

    Attributes:
        name: as in the vocabulary.
        value: a number, or one for each event.
        sigma: standard deviation(s) of the estimate, likewise.
        unit: SI; "1" for a ratio.
    """

    name: str
    value: float | tuple[float, ...]
    sigma: float | tuple[float, ...]
    unit: str

    def as_json(self) -> dict[str, Any]:
        """Return the contract's object of a parameter."""
        return {"value": _plain(self.value), "sigma": _plain(self.sigma), "unit": self.unit}


@dataclass(frozen=True, slots=True)
class Alternative:
    """Another effect that would explain what a finding explains."""

    effect: str
    component: str
    probability: float

    def as_json(self) -> dict[str, Any]:
        """Return the contract's object of an alternative."""
        return {"effect": self.effect, "component": self.component, "probability": self.probability}


@dataclass(frozen=True, slots=True)
class Where:
    """Where a mismatch is seen.

    Attributes:
        channels: on which it shows, strongest first.
        intervals: (start, end) on the recording's clock [s]; empty where it acts all the time.
        regime: of the drive in which it shows, in words.
        laps: numbers of the laps from 0, over all recordings in their order, in which it acts; empty for all.
        places: (x, y) on the floor [m] in the middle of each interval.
    """

    channels: tuple[str, ...] = ()
    intervals: tuple[tuple[float, float], ...] = ()
    regime: str = ""
    laps: tuple[int, ...] = ()
    places: tuple[tuple[float, float], ...] = ()

    def as_json(self) -> dict[str, Any]:
        """Return the contract's object of a place."""
        return {
            "channels": list(self.channels),
            "intervals": [list(interval) for interval in self.intervals],
            "regime": self.regime,
            "laps": list(self.laps),
            "places": [list(place) for place in self.places],
        }


@dataclass(frozen=True, slots=True)
class Finding:
    """One piece of physics that the simulation leaves out.

    Attributes:
        effect: of the vocabulary, or "unknown".
        component: on which it acts.
        probability: of this effect on this component, against all others considered.
        alternatives: what the recording cannot tell from it, likeliest first.
        where: it is seen.
        parameters: of its model.
        explained: share of the mismatch's chi-square that it takes away, 0 to 1.
        says: it in a sentence that one engineer says to another.
        depends_on: for "unknown", the quantities on which the leftover depends.
        separates: which drive would tell it from its alternatives; empty where there are none.
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

    @property
    def key(self) -> Key:
        """What it is called."""
        return self.effect, self.component

    def as_json(self) -> dict[str, Any]:
        """Return the contract's object of a finding."""
        answer: dict[str, Any] = {
            "effect": self.effect,
            "component": self.component,
            "probability": self.probability,
            "alternatives": [one.as_json() for one in self.alternatives],
            "where": self.where.as_json(),
            "parameters": {one.name: one.as_json() for one in self.parameters},
            "explained": self.explained,
            "says": self.says,
            "separates": self.separates,
        }
        if self.effect == "unknown":
            answer["depends_on"] = list(self.depends_on)
        return answer


@dataclass(frozen=True, slots=True)
class Calibrated:
    """What a recording with poses calibrates, whether or not it is a finding.

    Attributes:
        effect: of the vocabulary, or `reference_offset`, how the reference is mounted.
        component: that it is of.
        parameters: of it.
    """

    effect: str
    component: str
    parameters: tuple[Parameter, ...]

    def as_json(self) -> dict[str, Any]:
        """Return the object of what was calibrated."""
        return {
            "effect": self.effect,
            "component": self.component,
            "parameters": {one.name: one.as_json() for one in self.parameters},
        }


@dataclass(frozen=True, slots=True)
class Change:
    """A normalised residual without and with what was found; 1.0 is the noise that is expected."""

    before: float
    after: float

    def undone(self) -> Self:
        """Return the change where nothing is changed."""
        return replace(self, after=self.before)

    def as_json(self) -> dict[str, float]:
        """Return the contract's object of a change."""
        return {"before": self.before, "after": self.after}


@dataclass(frozen=True, slots=True)
class Fit:
    """How far the found effects bring simulation and recording together.

    Attributes:
        metric: what the numbers are, in words.
        train: on the data that were fitted.
        heldout: on laps or blocks whose data no parameter saw.
        channels: of each channel, held out.
        gain: held-out decrease of half the chi-square, and its standard deviation.
        rerun: of each channel, open-loop mismatch of the simulator run over the held-out laps from
            the effects file alone [m, rad]: without and with the effects.
        noise: levels used, by name, with unit in the name.
        usual_noise: the same levels of a usual robot; of poses, 1 is what their file states.
    """

    metric: str
    train: Change
    heldout: Change
    channels: dict[str, Change] = field(default_factory=dict)
    gain: tuple[float, float] = (0.0, 0.0)
    rerun: dict[str, Change] = field(default_factory=dict)
    noise: dict[str, float] = field(default_factory=dict)
    usual_noise: dict[str, float] = field(default_factory=dict)

    @property
    def unusual_noise(self) -> tuple[str, ...]:
        """What is said of levels that differ from usual ones by more than they are expected to."""
        return tuple(
            f"{name.replace('[', '').replace(']', '').replace(' 1', '')}: {self.noise[name]:.2g}, "
            f"{self.noise[name] / usual:.2g} times as much as is usual"
            for name, usual in self.usual_noise.items()
            if name in self.noise and not 1.0 / USUAL_FACTOR < self.noise[name] / usual < USUAL_FACTOR
        )

    def unchanged(self) -> Self:
        """Return the fit where nothing is added to the robot as described."""
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
        return {
            "metric": self.metric,
            "train": self.train.as_json(),
            "heldout": self.heldout.as_json(),
            "channels": {name: change.as_json() for name, change in self.channels.items()},
            "gain": {"value": self.gain[0], "sigma": self.gain[1]},
            "rerun": {name: change.as_json() for name, change in self.rerun.items()},
            "noise": dict(self.noise),
            "usual_noise": dict(self.usual_noise),
        }


@dataclass(frozen=True, slots=True)
class Trace:
    """The mismatch of one recording over its windows, for plots.

    Attributes:
        recording: its name.
        time: (K,) end of each window on the recording's clock [s].
        path: (K, 2) where truck a was [m].
        lap: (K,) number of the lap, -1 between laps.
        before: (K, C) whitened residual of each channel without the effects; nan where not read.
        after: (K, C) likewise with them.
    """

    recording: str
    time: Array
    path: Array
    lap: Array
    before: Array
    after: Array


@dataclass(frozen=True, slots=True)
class Signature:
    """What a finding looks like: the mismatch against the quantity on which it depends.

    Attributes:
        finding: number of the finding.
        quantity: on the horizontal axis, with its unit as shown.
        channel: on the vertical axis.
        at: (B,) middle of each bin.
        found: (B,) mean of what was recorded minus everything else that was found, in sigma.
        sigma: (B,) standard error of it.
        predicted: (B,) by the effect's model.
    """

    finding: int
    quantity: str
    channel: str
    at: Array
    found: Array
    sigma: Array
    predicted: Array


@dataclass(frozen=True, slots=True)
class Evidence:
    """What a report draws; not part of the JSON.

    Attributes:
        channels: names of the columns of the traces.
        traces: one for each recording.
        signatures: of the findings.
        candidates: every effect and component considered, with the gain in log likelihood of adding it
            alone and its probability of being in the right set, likeliest first.
    """

    channels: tuple[str, ...] = ()
    traces: tuple[Trace, ...] = ()
    signatures: tuple[Signature, ...] = ()
    candidates: tuple[tuple[str, str, float, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """The answer to recordings of one robot.

    Attributes:
        verdict: agreement, mismatch or insufficient.
        says: it in a sentence; for "insufficient", what to record.
        findings: most of the mismatch first.
        fit: residuals without and with the findings, or None where nothing could be held against.
        unexplained: share of the mismatch's chi-square that is left, 0 to 1.
        depends_on: quantities on which the leftover depends.
        robot: name of the vehicle.
        recordings: names, in order.
        drive_next: which drives would tell more, in words.
        evidence: for the report.
        effects: what was found and calibrated as the simulator takes it, "unknown" excepted.
        calibrated: what is in the effects beside the findings: numbers of robot and reference that are
            known better than the file says, though nothing says that the file is wrong.
        traces: what is there, but changes what the simulation misses by less than a twentieth.
        complete: whether the search ended by itself, and not for its budget of time.
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
            "calibrated": [single.as_json() for single in self.calibrated],
            "traces": [single.as_json() for single in self.traces],
            "complete": self.complete,
        }


def _plain(value: float | tuple[float, ...]) -> float | list[float]:
    return list(value) if isinstance(value, tuple) else value
