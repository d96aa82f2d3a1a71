"""What a finding is called among engineers: sentences, regimes, and the drives that separate effects."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.effects import EFFECTS

if TYPE_CHECKING:
    from collections.abc import Iterable

    from omnimate.effects.effect import Effect
    from omnimate.vehicle.parameters import VehicleParameters

_DRIVES = {kind.name: kind.separating_drive for kind in EFFECTS if kind.separating_drive}


def regime(effect: Effect) -> str:
    """Return in which regime of the drive an effect shows."""
    return effect.regime.format(component=effect.component, order=getattr(effect, "order", 1.0))


def sentence(effect: Effect, vehicle: VehicleParameters) -> str:
    """Return a finding in a sentence."""
    text = effect.describe(vehicle)
    return text[0].upper() + text[1:]


def drives_for(effects: Iterable[str]) -> tuple[str, ...]:
    """Return one drive for each effect, by name, that separates it from others."""
    return tuple(dict.fromkeys(_DRIVES[one] for one in effects if one in _DRIVES))
