"""The figures of the papers, drawn from simulated drives."""

import pytest

from studies.papers.figures import draw_all


@pytest.mark.slow
def test_all_figures_of_the_papers_are_drawn(tmp_path):
    names = [path.stem for path in draw_all(tmp_path / "new")]
    assert [name[:3] for name in names] == ["u06", "u11", "c08", "c10", "o05", "o06", "o07", "o08", "gro"]
    for name in names:
        assert (tmp_path / "new" / f"{name}.png").read_bytes().startswith(b"\x89PNG")
