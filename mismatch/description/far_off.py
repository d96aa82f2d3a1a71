"""The diagnosis of a robot that vehicle.toml describes grossly wrong; small effects come after that."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from omnimate.effects import CALIBRATED, effect_named
from omnimate.effects.words import component_in_words
from omnimate.mismatch.candidates.terms import UNKNOWN
from omnimate.mismatch.description.stretches import STRETCH
from omnimate.mismatch.diagnosis import Alternative, Change, Diagnosis, Finding, Fit, Parameter, Where

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.effects.effect import Effect
    from omnimate.mismatch.description.first_look import Look
    from omnimate.vehicle.parameters import Truck
    from omnimate.vehicle.recording import Recording

METRIC = (
    "root mean square of what plain odometry misses over stretches of up to {:g} s, in units of what the "
    "corrected robot misses; held out: each stretch with numbers fitted to others"
)
MAX_PROBABILITY = 0.999  # that is reported: the models are approximate
MIN_ALTERNATIVE = 0.01  # probability of an alternative that is reported
_DESCRIPTION = "which encoder is which wheel, and the sign of its counts"
_ADVICE = "correct vehicle.toml, and diagnose again: smaller effects cannot be identified before that"


def far_off(recordings: Sequence[Recording], look: Look) -> Diagnosis:
    """Return the diagnosis with the errors of vehicle.toml as findings."""
    truck, robot = recordings[0].vehicle.trucks[look.truck], recordings[0].vehicle
    names = tuple(recording.source for recording in recordings)
    sides = (*_diameter(look, truck, 0), *_diameter(look, truck, 1))
    findings = (*_wiring(look), *_wheelbase(look, truck), *sides)
    says = (
        f"{' '.join(finding.says for finding in findings)} "
        f"Plain odometry misses {1e3 * look.nominal:.0f} mm over up to {STRETCH:g} s as described, and "
        f"{1e3 * look.heldout:.0f} mm on stretches that no number was fitted to."
    )
    depends = tuple(quantity for finding in findings for quantity in finding.depends_on)
    left = min(1.0, (look.heldout / look.nominal) ** 2)
    before, after = look.nominal / look.train, look.heldout / look.train
    noise = {f"odometry over up to {STRETCH:g} s [m]": look.train}
    fit = Fit(METRIC.format(STRETCH), Change(before, 1.0), Change(before, after), noise=noise)
    return Diagnosis("mismatch", says, findings, fit, left, depends, robot.name, names, (_ADVICE,))


def _wiring(look: Look) -> tuple[Finding, ...]:
    """Return a finding where the encoders are assigned or signed wrongly."""
    if not look.wiring.faults:
        return ()
    same = "".join(f" (or {wiring}, which looks the same here)" for wiring in look.equals)
    says = f"The wheels of {component_in_words(look.truck)} are described wrongly: {look.wiring}{same}."
    where = Where(regime="always")
    share, probability = float(look.shares[3]), min(look.probability, MAX_PROBABILITY)
    finding = Finding(UNKNOWN, look.truck, probability, (), where, (), share, says, (_DESCRIPTION,))
    return (finding,)


def _wheelbase(look: Look, truck: Truck) -> tuple[Finding, ...]:
    kind = _number_of(look.truck)
    others = (
        (Alternative(kind.alternatives[0], look.truck, look.scrubs),) if look.scrubs > MIN_ALTERNATIVE else ()
    )
    says = (
        f"{component_in_words(look.truck).capitalize()} turns as if its wheelbase were "
        f"{1e3 * float(look.ratios[2]) * truck.wheelbase:.4g} mm, not {1e3 * truck.wheelbase:.4g} mm."
    )
    probability = look.probability * (1.0 - look.scrubs)
    return _number(look, 2, Finding(kind.name, look.truck, probability, others, says=says))


def _diameter(look: Look, truck: Truck, side: int) -> tuple[Finding, ...]:
    """Return a finding where a wheel does not travel what it rolls: by its diameter or, if less, by slip."""
    wheel = f"{look.truck}.{('left', 'right')[side]}"
    kind = _number_of(wheel)
    nominal = (truck.wheel_diameter_left, truck.wheel_diameter_right)[side]
    ratio = float(look.ratios[side])
    says = (
        f"{component_in_words(wheel).capitalize()} travels {ratio:.2f} of what a wheel of "
        f"{1e3 * nominal:.4g} mm rolls"
    )
    if ratio > 1.0:
        return _number(look, side, Finding(kind.name, wheel, look.probability, says=f"{says}."))
    half = 0.5 * look.probability
    finding = Finding(
        kind.name,
        wheel,
        half,
        (Alternative(kind.alternatives[0], wheel, half),),
        says=f"{says}: it is smaller, or slips all the time.",
        separates="a tape round the wheel; the same straight on a floor that grips",
    )
    return _number(look, side, finding)


def _number_of(component: str) -> type[Effect]:
    """Return the effect of a wrong parameter of a component in vehicle.toml."""
    return next(kind for kind in CALIBRATED if component in kind.components)


def _number(look: Look, which: int, finding: Finding) -> tuple[Finding, ...]:
    """Return a finding with its ratio, where that is grossly wrong."""
    if not look.far[which]:
        return ()
    parameter = Parameter("ratio", float(look.ratios[which]), float(look.sigmas[which]), "1")
    return (
        replace(
            finding,
            probability=min(finding.probability, MAX_PROBABILITY),
            where=Where(regime=effect_named(finding.effect).regime),
            parameters=(parameter,),
            explained=float(look.shares[which]),
        ),
    )
