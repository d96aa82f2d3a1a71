"""Play: an output that follows its input only when that reaches the end of a gap."""

from __future__ import annotations

from omnimate.vehicle.compiled import Array, compiled


def follow(inputs: Array, output: float, width: float) -> Array:
    """Return what follows inputs `(K,)` through a play, `(K,)`: the play operator.

    Args:
        inputs: Positions of the input, shape `(K,)`, in any unit.
        output: Position of the output before the first input, in that unit.
        width: Width of the whole play, in that unit.
    """
    return _follow(inputs, output, 0.5 * width)


@compiled
def _follow(inputs: Array, output: float, half: float) -> Array:
    outputs = inputs.copy()
    for number in range(len(inputs)):
        output = min(max(output, inputs[number] - half), inputs[number] + half)
        outputs[number] = output
    return outputs
