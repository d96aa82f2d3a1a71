"""Clusters of return errors."""

from pathlib import Path

import numpy as np
import pytest

from omnimate.calib.umbmark.return_errors import ReturnErrors
from omnimate.figures.clusters import Clusters, plot_clusters
from omnimate.figures.files import PlotError


def errors(size: float, seed: int = 1) -> ReturnErrors:
    rng = np.random.default_rng(seed)
    cw, ccw = (rng.normal(0.0, 0.025, (5, 3)) + centre for centre in ([size, size, 0.0], [size, -size, 0.0]))
    return ReturnErrors(cw, ccw, 4.0)


@pytest.mark.parametrize(
    ("suffix", "magic"),
    [(".png", b"\x89PNG\r\n"), (".svg", b"<?xml"), (".pdf", b"%PDF"), (".PNG", b"\x89PNG")],
)
def test_the_suffix_is_the_format(tmp_path: Path, suffix: str, magic: bytes) -> None:
    """PNG, SVG and PDF, as the name says."""
    path = tmp_path / f"figure{suffix}"
    plot_clusters([Clusters("truck a", errors(0.2), errors(0.01))], path)
    assert path.read_bytes().startswith(magic)


def test_before_and_after_are_named_with_their_size(tmp_path: Path) -> None:
    """One panel for each experiment, millimetres on the axes, both sizes above, both stages in the legend."""
    texts = drawn_texts(tmp_path, [Clusters(name, errors(0.2), errors(0.01)) for name in "abc"])
    assert texts.count("return error in x [mm]") == texts.count("return error in y [mm]") == 3
    assert sum("mm before" in text and "mm after" in text for text in texts) == 3
    for label in ("cw, before", "ccw, before", "cw, after", "ccw, after", "centre of gravity"):
        assert texts.count(label) == 1


def test_figure_6_has_no_after(tmp_path: Path) -> None:
    """Without calibrated runs nothing speaks of before and after."""
    texts = drawn_texts(tmp_path, [Clusters("truck a", errors(0.2))])
    assert not any("before" in text or "after" in text for text in texts)
    assert texts.count("cw") == texts.count("ccw") == 1


def drawn_texts(tmp_path: Path, panels: list[Clusters]) -> list[str]:
    """Return the texts of a cluster figure, in the order in which the SVG has them as comments."""
    path = tmp_path / "figure.svg"
    plot_clusters(panels, path)
    lines = path.read_text(encoding="utf-8").splitlines()
    return [line.strip().removeprefix("<!--").removesuffix("-->").strip() for line in lines if "<!--" in line]


def test_the_same_figure_is_the_same_file(tmp_path: Path) -> None:
    """No date, no random names: figures can be compared."""
    contents = []
    for name in ("one.svg", "two.svg"):
        plot_clusters([Clusters("truck a", errors(0.2), errors(0.01))], tmp_path / name)
        contents.append((tmp_path / name).read_bytes())
    assert contents[0] == contents[1]


@pytest.mark.parametrize("name", ["figure.doc", "figure", "nowhere/figure.png"])
def test_bad_names_are_refused(tmp_path: Path, name: str) -> None:
    """An unknown format or a missing folder is an error before anything is drawn."""
    with pytest.raises(PlotError, match=r"expected|create"):
        plot_clusters([Clusters("truck a", errors(0.2))], tmp_path / name)
