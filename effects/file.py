"""The effects file: written by a diagnosis, and loaded by the simulator to reproduce the real robot.

One table for each effect, in the order in which effects of one stage act:

    [[effect]]
    name = "wheel_eccentricity"
    component = "b.right"
    amplitude = 4.1e-4
    phase = 1.2
    sigma = { amplitude = 2.0e-5 }

`sigma` is for readers; the simulator ignores it.
"""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import tomli_w

from omnimate.effects import effect_named
from omnimate.effects.errors import EffectError, EffectsFileError
from omnimate.vehicle.atomic import write_text
from omnimate.vehicle.errors import TableError
from omnimate.vehicle.tables import parse_toml, read_toml, value_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from omnimate.effects.effect import Effect

    Sigmas = Mapping[str, float | Sequence[float]]


def save_effects(path: Path | str, effects: Sequence[Effect], sigmas: Sequence[Sigmas] = ()) -> None:
    """Write an effects file, whole or not at all; effects are in the order in which they act.

    `sigmas` are standard deviations of the parameters of each effect, by name, or of a law's terms by their
    text; none by default.
    """
    write_text(Path(path), format_effects(effects, sigmas))


def format_effects(effects: Sequence[Effect], sigmas: Sequence[Sigmas] = ()) -> str:
    """Return the text of an effects file; reading it back gives equal effects."""
    known: Iterable[Sigmas] = sigmas or [{}] * len(effects)
    entries: list[dict[str, Any]] = []
    for effect, sigma in zip(effects, known, strict=True):
        entry = {"name": effect.name, "component": effect.component, **effect.values()}
        entries.append({**entry, "sigma": dict(sigma)} if sigma else entry)
    return tomli_w.dumps({"effect": entries})


def load_effects(path: Path | str) -> tuple[Effect, ...]:
    """Return the effects of a file.

    Raises:
        EffectsFileError: The file cannot be read or is not TOML, or an entry describes no effect.
    """
    try:
        return _effects(read_toml(path))
    except TableError as error:
        raise EffectsFileError(path, error.key, error.problem) from error


def parse_effects(text: str, source: Path | str = "effects.toml") -> tuple[Effect, ...]:
    """Return the effects that a text describes; `source` is named in errors.

    Raises:
        EffectsFileError: The text is not TOML, or an entry describes no effect.
    """
    try:
        return _effects(parse_toml(text))
    except TableError as error:
        raise EffectsFileError(source, error.key, error.problem) from error


def _effects(document: Mapping[str, Any]) -> tuple[Effect, ...]:
    for key in document:
        if key != "effect":
            raise TableError(key, "unknown key; expected [[effect]] tables alone")
    entries = document.get("effect", [])
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise TableError("effect", "expected [[effect]] tables")
    return tuple(_effect(f"effect {place}", entry) for place, entry in enumerate(entries, start=1))


def _effect(place: str, entry: Mapping[str, Any]) -> Effect:
    for key in ("name", "component"):
        if not isinstance(entry.get(key), str):
            given = repr(entry[key]) if key in entry else "missing"
            raise TableError(f"{place}: {key}", f"{given}; expected text")
    try:
        kind = effect_named(entry["name"])
        values = _values(f"{place} ({kind.name})", entry, kind)
        return kind(entry["component"], **values)
    except EffectError as error:
        raise TableError(place, str(error)) from error


def _values(place: str, entry: Mapping[str, Any], kind: type[Effect]) -> dict[str, Any]:
    """Return the parameters; those with a null value are required, unknown keys are errors."""
    known = {field.name: str(field.type) for field in fields(kind) if field.name != "component"}
    for key in entry:
        if key not in (*known, "name", "component", "sigma"):
            raise TableError(f"{place}: {key}", f"unknown key; expected {', '.join(known)}")
    for parameter in kind.parameters:
        if parameter.null is not None and parameter.name not in entry:
            raise TableError(f"{place}: {parameter.name}", f"missing; expected a value in {parameter.unit}")
    return {
        name: _as_floats(value_of(known[name], entry[name], f"{place}: {name}"))
        for name in known
        if name in entry
    }


def _as_floats(value: Any) -> Any:  # noqa: ANN401  # a text, a number, or tuples of numbers
    if isinstance(value, tuple):
        return tuple(_as_floats(item) for item in value)
    return value if isinstance(value, str) else float(value)
