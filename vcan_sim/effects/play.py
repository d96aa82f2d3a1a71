"""Play: an output that follows its input only when that reaches the end of a gap."""

from __future__ import annotations

from vehicle.compiled import Array, compiled


def follow(inputs: Array, output: float, width: float) -> Array:
    """Return what follows inputs `(K,)` through a play, `(K,)`: the play operator.

    Args:
        inputs: of any unit.
        output: where it stood before.
        width: of the whole play, in that unit.
    """
    return _follow(inputs, output, 0.5 * width)


@compiled
def _follow(inputs: Array, output: float, half: float) -> Array:
    outputs = inputs.copy()
    for number in range(len(inputs)):
        output = min(max(output, inputs[number] - half), inputs[number] + half)
        outputs[number] = output
    return outputs
