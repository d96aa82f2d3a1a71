"""Figures of real robots come out as files of the format that their names ask for."""

from functools import partial

import numpy as np
import pytest

from omnimate.figures.files import PlotError
from studies.figures import plot_errors, plot_turns

COLUMNS = {"nominal": [0.005, 0.018], "calibrated": [0.003, 0.010], "found": [0.002, 0.012]}
ERRORS = partial(plot_errors, ["square/1", "free/2"], COLUMNS)
TURNS = partial(plot_turns, np.linspace(-3.0, 3.0, 20), np.linspace(-1.2, 1.2, 20), 2.5, title="a robot")


@pytest.mark.parametrize(
    ("draw", "words"), [(ERRORS, ("<!-- square/1 -->", "calibrated")), (TURNS, ("as described", "2.50"))]
)
def test_a_figure_names_what_it_shows_and_an_unknown_format_is_refused(tmp_path, draw, words):
    draw(tmp_path / "figure.svg")
    text = (tmp_path / "figure.svg").read_text()
    assert all(word in text for word in words)
    with pytest.raises(PlotError, match="unknown format"):
        draw(tmp_path / "figure.gif")
