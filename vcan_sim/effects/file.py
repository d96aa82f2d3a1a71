"""The effects file: what a diagnosis writes, and what lets the simulator do as the real robot does.

One table for each effect, in the order in which effects of one stage act:

    [[effect]]
    name = "wheel_eccentricity"
    component = "b.right"
    amplitude = 4.1e-4
    phase = 1.2
    sigma = { amplitude = 2.0e-5 }

`sigma` is for people; the simulator does not read it.
"""

from __future__ import annotations

import tomllib
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import tomli_w

from vcan_sim.effects import effect_named
from vcan_sim.errors import EffectsFileError, SimulationError
from vehicle.atomic import write_text

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from vcan_sim.effects.effect import Effect

_DEPTH = {"float": 0, "tuple[float, ...]": 1, "tuple[tuple[float, float], ...]": 2}
_SHAPES = ("a number", "a list of numbers", "a list of [start, end] pairs")


def save_effects(
    path: Path | str, effects: Sequence[Effect], sigmas: Sequence[Mapping[str, float]] = ()
) -> None:
    """Write an effects file, whole or not at all.

    Args:
        path: of the file.
        effects: in the order in which they act.
        sigmas: of each effect, standard deviations of its parameters; none by default.
    """
    write_text(Path(path), format_effects(effects, sigmas))


def format_effects(effects: Sequence[Effect], sigmas: Sequence[Mapping[str, float]] = ()) -> str:
    """Return the text of an effects file; reading it back gives equal effects."""
    known: Iterable[Mapping[str, float]] = sigmas or [{}] * len(effects)
    entries: list[dict[str, Any]] = []
    for effect, sigma in zip(effects, known, strict=True):
        entry = {"name": effect.name, "component": effect.component, **effect.values()}
        entries.append({**entry, "sigma": dict(sigma)} if sigma else entry)
    return tomli_w.dumps({"effect": entries})


def load_effects(path: Path | str) -> tuple[Effect, ...]:
    """Return the effects of a file.

    Raises:
        EffectsFileError: it cannot be read, is no TOML, or an entry describes no effect.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise EffectsFileError(path, "(file)", f"cannot be read: {error}") from error
    return parse_effects(text, path)


def parse_effects(text: str, source: Path | str = "effects.toml") -> tuple[Effect, ...]:
    """Return the effects that a text describes; `source` is named in errors.

    Raises:
        EffectsFileError: as `load_effects`.
    """
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise EffectsFileError(source, "(syntax)", f"not TOML: {error}") from error
    for key in document:
        if key != "effect":
            raise EffectsFileError(source, key, "unknown key; expected [[effect]] tables alone")
    entries = document.get("effect", [])
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise EffectsFileError(source, "effect", "expected [[effect]] tables")
    return tuple(_effect(source, f"effect {place}", entry) for place, entry in enumerate(entries, start=1))


def _effect(source: Path | str, place: str, entry: Mapping[str, Any]) -> Effect:
    for key in ("name", "component"):
        if not isinstance(entry.get(key), str):
            raise EffectsFileError(source, f"{place}: {key}", f"{entry.get(key)!r}; expected text")
    try:
        kind = effect_named(entry["name"])
        values = _values(source, f"{place} ({kind.name})", entry, kind)
        return kind(entry["component"], **values)
    except EffectsFileError:
        raise
    except SimulationError as error:
        raise EffectsFileError(source, place, str(error)) from error


def _values(source: Path | str, place: str, entry: Mapping[str, Any], kind: type[Effect]) -> dict[str, Any]:
    """Return the parameters; those that have a null value must be there, as must nothing unknown."""
    depth = {field.name: _DEPTH[str(field.type)] for field in fields(kind) if field.name != "component"}
    for key in entry:
        if key not in (*depth, "name", "component", "sigma"):
            raise EffectsFileError(source, f"{place}: {key}", f"unknown key; expected {', '.join(depth)}")
    for parameter in kind.parameters:
        if parameter.null is not None and parameter.name not in entry:
            raise EffectsFileError(source, f"{place}: {parameter.name}", f"missing; in {parameter.unit}")
    values = {}
    for name in depth.keys() & entry.keys():
        try:
            values[name] = _numbers(entry[name], depth[name])
        except (TypeError, OverflowError):
            problem = f"{entry[name]!r}; expected {_SHAPES[depth[name]]}"
            raise EffectsFileError(source, f"{place}: {name}", problem) from None
    return values


def _numbers(value: Any, depth: int) -> Any:  # noqa: ANN401  # from TOML: a number, or lists of them
    """Return a number, or lists of numbers as tuples; innermost of two levels are pairs.

    Raises:
        TypeError: it is something else.
    """
    if depth == 0:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise TypeError
        return float(value)
    if not isinstance(value, list) or (
        depth == 2 and any(not isinstance(p, list) or len(p) != 2 for p in value)
    ):
        raise TypeError
    return tuple(_numbers(part, depth - 1) for part in value)
