"""Figures of real robots come out as files of the format that their names ask for."""

import numpy as np
import pytest

from omnimate.figures.files import PlotError
from studies.figures import plot_errors, plot_turns


def test_errors_of_sets_are_drawn_side_by_side(tmp_path):
    columns = {"nominal": [0.005, 0.018], "calibrated": [0.003, 0.010], "found": [0.002, 0.012]}
    plot_errors(["square/1", "free/2"], columns, tmp_path / "errors.svg")
    text = (tmp_path / "errors.svg").read_text()
    assert text.count("<!-- square/1 -->") == 1
    assert "calibrated" in text


def test_turns_are_drawn_with_both_lines(tmp_path):
    wheels = np.linspace(-3.0, 3.0, 20)
    plot_turns(wheels, 0.4 * wheels, 2.5, tmp_path / "turns.svg", title="a robot")
    text = (tmp_path / "turns.svg").read_text()
    assert "as described" in text
    assert "2.50" in text


@pytest.mark.parametrize(
    "draw",
    [
        lambda path: plot_errors(["a"], {"b": [1.0]}, path),
        lambda path: plot_turns(np.ones(2), np.ones(2), 1.0, path),
    ],
)
def test_an_unknown_format_is_refused(tmp_path, draw):
    with pytest.raises(PlotError, match="unknown format"):
        draw(tmp_path / "errors.gif")
