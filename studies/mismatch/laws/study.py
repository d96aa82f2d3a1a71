"""The study of learned laws: each effect is left out of the library, and a law is learned in its place."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table

from omnimate.cli.tables import new_table
from omnimate.effects import effect_named
from omnimate.effects.effect import Effect
from omnimate.effects.file import format_effects
from omnimate.files.recordings.folder import load_recording
from omnimate.mismatch.candidates.regression import Regression
from omnimate.mismatch.candidates.terms import smooth_terms
from omnimate.mismatch.candidates.unknown import errors, sizes_of
from omnimate.mismatch.evidence.conditional_fit import ConditionalFit
from omnimate.mismatch.evidence.posterior import Posterior
from omnimate.mismatch.investigate import (
    posterior_with_background,
    startup_nuisances,
    whiten_with_estimated_noise,
)
from omnimate.mismatch.learn.law_terms import law_of, observed
from omnimate.mismatch.noise.levels import DEFAULT_LEVELS, NoiseLevels
from omnimate.mismatch.recording.response import column, response
from omnimate.mismatch.recording.signals import signals_of
from omnimate.mismatch.recording.windows import windows_of
from omnimate.vehicle.recording import Recording
from omnimate.vehicle.se2 import Array
from studies.figures import plot_recovery
from studies.mismatch import run
from studies.mismatch.engines.scene import Case, cases, scene, seed_of
from studies.mismatch.engines.vocabulary import label, set_bump_times
from studies.mismatch.engines.writing import MEASURING, write
from studies.mismatch.laws.baselines import gaussian_process, has_sindy, sindy
from studies.mismatch.run import Progress

QUICK = ("wheelbase", "radius_vs_speed", "joint_eccentricity")  # effects of the small study


@dataclass(frozen=True, slots=True)
class Pair:
    """Two drives of a robot along the same programme; floor and sensors scatter otherwise in each."""

    effect: Effect  # the effect that is concealed in both, as the library describes it
    seen: Recording  # the drive to learn from
    unseen: Recording  # the drive that no fit sees


def wanted(count: int, seed: int, *, quick: bool = False) -> Iterator[tuple[Case, int]]:
    """Yield cases of the corpus that conceal one effect, some of each effect, with their seeds.

    Poses are dense: where a recording hardly shows an effect, no law of it can be learned.
    """
    taken: dict[str, int] = {}
    for number, case in enumerate(cases(quick=False)):
        if case.kind != "single":
            continue
        name = case.effects[0][0]
        taken[name] = taken.get(name, 0) + 1
        if taken[name] <= count and (not quick or name in QUICK):
            yield replace(case, poses="mocap"), seed_of(seed, number)


def pair(folder: Path, case: Case, seed: int) -> Pair:
    """Write and load the two drives of a case."""
    setting = scene(case, seed)
    (fault,) = setting.faults
    parameters = {name: value for name, value in fault.parameters.items() if name not in {"radius", "start"}}
    named = label(fault.effect, fault.component, parameters)
    recordings = []
    for number in (1, 2):
        chance = np.random.default_rng([seed, 78, number])
        driven = setting.driven(setting.faults, chance)
        write(folder / str(number), setting.robot, driven, MEASURING[case.poses], 0.0, chance)
        recordings.append(load_recording(folder / str(number)))
        if fault.effect == "bump" and number == 1:
            column = setting.robot.channels.index(fault.component)
            set_bump_times(named, driven.time, driven.counts[:, column])
            parameters["times"] = named["parameters"]["times"]["value"]
    return Pair(library_effect(fault.effect, fault.component, parameters), *recordings)


def library_effect(name: str, component: str, parameters: Mapping[str, Any]) -> Effect:
    """Return the effect of the project's library with parameters that are numbers or lists of them."""

    def frozen(value: Any) -> Any:  # noqa: ANN401
        return tuple(map(frozen, value)) if isinstance(value, list) else value

    return effect_named(name)(component, **{name_of: frozen(value) for name_of, value in parameters.items()})


LAW, PROCESS, SINDY = "law", "Gaussian process", "pysindy"
METHODS = (LAW, PROCESS, SINDY)

Recovery = dict[str, Any]
"""What one case came to: `effect` and `component` that are concealed and in no library; `gain` of the effect
itself with its true parameters on the drive that nothing has seen, the decrease of half the chi-square [nat];
`gains` likewise of what each method learned from the other drive, by its name; `law` as a file of effects,
empty where there is none.
"""


def recovered(question: tuple[Case, int]) -> Recovery:
    """Return what is recovered in a case, by the seed of its drives."""
    with tempfile.TemporaryDirectory() as place:
        return recovered_from(pair(Path(place), *question))


def recovered_from(drives: Pair) -> Recovery:
    """Return what is recovered of an effect that two drives conceal."""
    effect = drives.effect
    posterior = _posterior(drives.seen, effect)
    unseen = _posterior(drives.unseen, effect, posterior.regression.noise)
    conditional, held_out = posterior.given(()), unseen.given(())
    itself = _gain(held_out, _part(unseen, held_out, (effect,)))
    ways = _ways(posterior, effect.component)
    laws = [law_of(posterior, conditional, effect.component, way) for way in ways]
    best = max((law for law in laws if law is not None), key=lambda law: law.total, default=None)
    gains = {LAW: 0.0 if best is None else _gain(held_out, _part(unseen, held_out, best.effects))}
    for name, method in ((PROCESS, gaussian_process), *(((SINDY, sindy),) if has_sindy() else ())):
        offers = []
        for way in ways:
            variables, columns = observed(posterior, conditional, effect.component, way)
            learned = method(
                variables,
                columns,
                conditional.residual,
                posterior.candidates.fold,
                sizes_of(effect.component, way),
            )
            fitted = _gain(conditional, columns(learned(variables)[:, None])[:, 0])
            there, shown = observed(unseen, held_out, effect.component, way)
            offers.append((fitted, _gain(held_out, shown(learned(there)[:, None])[:, 0])))
        gains[name] = max(offers)[1]
    return {
        "effect": effect.name,
        "component": effect.component,
        "gain": itself,
        "gains": gains,
        "law": "" if best is None else format_effects(best.effects),
    }


def _posterior(recording: Recording, effect: Effect, noise: NoiseLevels | None = None) -> Posterior:
    """Return a drive with what every robot has a little of, but nothing of an effect.

    Levels of noise are estimated with the effect as a nuisance, unless they are known: what is asked here is
    what a law recovers, and not how noise is told from it.
    """
    signals = (signals_of(recording),)
    regression = Regression([windows_of(one) for one in signals], noise or DEFAULT_LEVELS, ())
    library = [one for one in smooth_terms(signals) if one.effect != effect.name]
    if noise is None:
        nuisances = Regression(regression.windows, DEFAULT_LEVELS, ())
        nuisances.add(startup_nuisances(library, signals))
        nuisances.extend(
            [
                column(base, response(windows, (effect,)), 1.0)
                for windows, base in zip(nuisances.windows, nuisances.responses, strict=True)
            ],
            [1],
        )
        regression = regression.with_noise(whiten_with_estimated_noise(nuisances).noise)
    places = regression.add(library)
    return posterior_with_background(regression, library, places)


def _ways(posterior: Posterior, component: str) -> list[str]:
    """Return the quantities of a component that an error may change, those of its truck for a truck."""
    return list(
        dict.fromkeys(
            error.acts_on
            for error in errors(posterior.regression.windows[0])
            if error.component == component and error.acts_on
        )
    )


def _part(posterior: Posterior, conditional: ConditionalFit, effects: tuple[Effect, ...]) -> Array:
    """Return what effects would explain of a drive's rows, `(V,)`."""
    regression = posterior.regression
    raw = [
        column(base, response(windows, effects), 1.0)
        for windows, base in zip(regression.windows, regression.responses, strict=True)
    ]
    return np.asarray(conditional.project_out(regression.whitened(raw))[:, 0])


def _gain(conditional: ConditionalFit, part: Array) -> float:
    """Return by how much half the chi-square of a drive falls without a part `(V,)` of its rows [nat]."""
    return float(part @ conditional.residual - 0.5 * part @ part)


CASES = 3  # of each effect
CLEAR = 30.0  # [nat] of the effect's own gain, below which a drive hardly shows it: 7.7 sigma
ENOUGH = 0.8  # share of that gain that a law is to recover
RESULT, FIGURE = "laws.json", "laws.png"


def study(
    place: Path,
    seed: int,
    jobs: int,
    progress: Progress,
    figures: Path | None = None,
    *,
    count: int = CASES,
    quick: bool = False,
) -> Iterator[Table | str]:
    """Carry the study out, and yield its table and sentences; PlotError where the figure is not written."""
    place.mkdir(parents=True, exist_ok=True)
    questions = {
        f"{case.effects[0][0]}-{number}": (case, number) for case, number in wanted(count, seed, quick=quick)
    }
    with progress("learning laws") as report:
        answers = run.ask_all(recovered, questions, jobs, report, place / "laws.answers.jsonl")
    recoveries = [answers[name] for name in questions]
    (place / RESULT).write_text(json.dumps(recoveries, indent=1), encoding="utf-8")
    if not has_sindy():
        yield f"{SINDY} is not installed (pip install omnimate[laws]): it is left out"
    clear = [one for one in recoveries if one["gain"] >= CLEAR]
    if len(clear) < len(recoveries):
        yield (
            f"{len(recoveries) - len(clear)} of {len(recoveries)} drives hardly show what is concealed "
            f"(gain below {CLEAR:g} nat): left out"
        )
    if not clear:
        return
    yield table(clear)
    if figures is not None:
        plot_recovery({name: shares(_of(clear, name)) for name in _effects(clear)}, ENOUGH, figures / FIGURE)


def shares(recoveries: Sequence[Recovery]) -> dict[str, list[float]]:
    """Return of each method the shares of the effects' gains that it recovers."""
    return {
        method: [one["gains"][method] / one["gain"] for one in recoveries]
        for method in METHODS
        if all(method in one["gains"] for one in recoveries)
    }


def table(recoveries: Sequence[Recovery]) -> Table:
    """Return a table of the shares that are recovered, a row for each effect."""
    heads = [head for method in shares(recoveries) for head in (f"{method}\nmedian", f"{ENOUGH:g}", "< 0")]
    what = "Laws learned in the place of effects: share of the effect's own gain on an unseen drive"
    shown = new_table(what, ("effect",), ("cases", *heads))
    shown.caption = (
        f"{ENOUGH:g}: cases in which {ENOUGH:g} or more of it is recovered; < 0: worse than nothing"
    )
    rows = [(name, _of(recoveries, name)) for name in _effects(recoveries)]
    for name, chosen in [*rows, ("all", recoveries)]:
        cells = []
        for values in shares(chosen).values():
            enough, worse = (np.sum(np.array(values) >= ENOUGH), np.sum(np.array(values) < 0.0))
            cells += [f"{np.median(values):.2f}", f"{enough}/{len(values)}", str(worse)]
        shown.add_row(name, str(len(chosen)), *cells, end_section=name == _effects(recoveries)[-1])
    return shown


def _effects(recoveries: Sequence[Recovery]) -> list[str]:
    """Return the effects in the order of what a law recovers of them, most first."""
    names = list(dict.fromkeys(one["effect"] for one in recoveries))
    return sorted(names, key=lambda name: -float(np.median(shares(_of(recoveries, name))[LAW])))


def _of(recoveries: Sequence[Recovery], effect: str) -> list[Recovery]:
    return [one for one in recoveries if one["effect"] == effect]
