"""The play operator of backlash: the output moves only when the input reaches an end of the gap."""

from __future__ import annotations

from omnimate.vehicle.compiled import Array, compiled


def play_output(inputs: Array, output: float, width: float) -> Array:
    """Return the outputs `(K,)` of the play operator for positions `(K,)` of the input, in any unit.

    `output` is the position of the output before them, `width` the full width of the play.
    """
    return _play_output(inputs, output, 0.5 * width)


@compiled
def _play_output(inputs: Array, output: float, half: float) -> Array:
    outputs = inputs.copy()
    for number in range(len(inputs)):
        output = min(max(output, inputs[number] - half), inputs[number] + half)
        outputs[number] = output
    return outputs
