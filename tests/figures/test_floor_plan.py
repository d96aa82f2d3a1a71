"""Floor plans of drives."""

from pathlib import Path

import numpy as np
import pytest

from omnimate.figures.files import PlotError
from omnimate.figures.floor_plan import Track, plot_floor_plan

SQUARE = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0], [0.0, 0.0]])


def test_floor_plan(tmp_path: Path) -> None:
    """Every track and the fixes are in the legend; axes in metres."""
    path = tmp_path / "plan.svg"
    tracks = [Track("driven", SQUARE), Track("odometry", SQUARE * 1.01, dashed=True)]
    plot_floor_plan(tracks, path, title="lap 1", fixes=SQUARE[[0, -1]])
    text = path.read_text(encoding="utf-8")
    for words in ("driven", "odometry", "absolute fix", "lap 1", "x [m]", "y [m]"):
        assert f"<!-- {words} -->" in text


def test_a_figure_that_cannot_be_written_leaves_nothing(tmp_path: Path) -> None:
    """Where a folder has the figure's name, the error says so and no part of a file remains."""
    (tmp_path / "figure.png").mkdir()
    with pytest.raises(PlotError, match=r"cannot be written: Is a directory$"):
        plot_floor_plan([Track("driven", SQUARE)], tmp_path / "figure.png")
    assert [path.name for path in tmp_path.iterdir()] == ["figure.png"]
