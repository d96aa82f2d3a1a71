"""What a drive cannot show, and the drive that would."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.effects import EFFECTS
from omnimate.effects.words import component_in_words

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from omnimate.mismatch.diagnosis import Key
    from omnimate.mismatch.evidence.posterior import Posterior

# What a drive must be able to show before "agreement" means something: coefficients with a standard
# deviation of less than this share of what robots in use are off by.
_SEEN = 0.7


def blind(posterior: Posterior) -> list[Key]:
    """Return which of an owner's numbers this drive would not show to be wrong, were they."""
    needed = [number for number, term in enumerate(posterior.terms) if term.kind.calibrated]
    gram, _ = posterior.given(()).gram_and_score([posterior.places[number].start for number in needed])
    spreads = 1.0 / np.sqrt(np.diagonal(gram) + 1.0)
    return [
        posterior.terms[number].key for number, spread in zip(needed, spreads, strict=True) if spread > _SEEN
    ]


def unseen_in_words(unseen: Sequence[Key]) -> tuple[str, tuple[str, ...]]:
    """Return a sentence on what a drive cannot show, and the drives that would."""
    drives = drives_for(sorted({effect for effect, _ in unseen}))
    what = ", ".join(
        f"the {effect.replace('_', ' ')} of {component_in_words(component)}"
        for effect, component in unseen[:4]
    )
    return f"Nothing stands out, but this drive cannot show {what}. Drive: {'; '.join(drives)}.", drives


def drives_for(effects: Iterable[str]) -> tuple[str, ...]:
    """Return one drive for each effect, by name, that separates it from others."""
    drives = {kind.name: kind.separating_drive for kind in EFFECTS if kind.separating_drive}
    return tuple(dict.fromkeys(drives[effect] for effect in effects if effect in drives))
