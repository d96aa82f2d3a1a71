r"""The order of the signal path, and which effects act at which of its stages.

wheel turns -> [encoder] -> counts
     \-> [travel] of the wheel over the ground -> [body] of the truck -> linkage -> [reading] -> counts
                                                      \-> [poses] as measured from outside

The simulator follows this path step by step (`altered_path`), a diagnosis for a whole recording
(`replay`); both go through `by_stage`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.effects.effect import STAGES

if TYPE_CHECKING:
    from collections.abc import Iterable

    from omnimate.effects.block import Block
    from omnimate.effects.effect import Effect, Stage


def by_stage(effects: Iterable[Effect]) -> dict[Stage, tuple[Effect, ...]]:
    """Return the effects of every stage, the stages in the order of the path, the effects as given."""
    staged: dict[Stage, list[Effect]] = {stage: [] for stage in STAGES}
    for effect in effects:
        staged[effect.acts_at()].append(effect)
    return {stage: tuple(acting) for stage, acting in staged.items()}


def replay(block: Block, effects: Iterable[Effect]) -> Block:
    """Return the steps of a nominal recording with effects applied, stage after stage, in the order given.

    Angles and turns are counted ones here, so that effects on encoders are inverted (`recover`).
    """
    for stage, acting in by_stage(effects).items():
        if stage == "body":
            block = block.rolled()
        for effect in acting:
            block = effect.recover(block) if stage == "encoder" else effect.act(block)[0]
    return block
