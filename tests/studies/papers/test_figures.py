"""The figures of the papers, drawn from simulated drives."""

import pytest

from studies.papers.figures import draw_all
from studies.papers.protocols import lap_errors_of


@pytest.mark.slow
def test_all_figures_of_the_papers_are_drawn(tmp_path):
    names = [path.stem for path in draw_all(tmp_path / "new")]
    assert [name[:3] for name in names] == ["u06", "u11", "c08", "c10", "o05", "o06", "o07", "o08", "gro"]
    for name in names:
        assert (tmp_path / "new" / f"{name}.png").read_bytes().startswith(b"\x89PNG")


def test_figures_show_the_first_robot_of_the_table():
    assert lap_errors_of(0, "cw")["OmniMate"].shape == (10, 3)
