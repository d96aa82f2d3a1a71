"""OptiOdom folders: the real robot."""

import gzip
from pathlib import Path

import pytest

from omnimate.calib.errors import DirectionError
from omnimate.calib.umbmark.experiment import calibrate
from studies.datasets.optiodom.drives import OptiOdomError
from studies.datasets.optiodom.scores import experiment_of_optiodom, read_squares

FIRST = "real/optiodom/diff/square/230620202042"
METADATA = "type,diff\nngear,1\nencRes,1000\nLi,0.2\nDi,0.1,0.1\nN,2\nL,1\n"


def folder(path: Path, metadata: str = METADATA, rows: str = "0,0,0,0,0,0\n0.05,0,0,0,5,5\n") -> Path:
    (path / "set_metadata.csv").write_text(metadata, encoding="utf-8")
    for number in (1, 2):
        with gzip.open(path / f"set_run-{number:02d}.csv.gz", "wt") as file:
            file.write(rows)
    return path


def test_every_square_set(shared_data: Path) -> None:
    """All four sets read, half cw and half ccw in the order that their page states, and all become better."""
    for path in sorted((shared_data / "real/optiodom/diff/square").iterdir()):
        data = read_squares(path)
        half = len(data.runs) // 2
        assert [run.direction for run in data.runs] == ["cw"] * half + ["ccw"] * half
        for method in ("printed", "exact"):
            calibration = calibrate(experiment_of_optiodom(path), method)
            assert calibration.errors.e_max_syst < 0.12 * calibration.experiment.errors.e_max_syst


def test_other_paths_and_robots_are_refused(shared_data: Path) -> None:
    """Circles have no side, and the tricycle is no differential drive."""
    for path, words in (
        ("diff/circular/250620202104", "no set of squares"),
        ("tricyc/square/140120211430", "diff"),
    ):
        with pytest.raises(OptiOdomError, match=words):
            read_squares(shared_data / "real/optiodom" / path)


@pytest.mark.parametrize(
    ("metadata", "rows", "words"),
    [
        (METADATA.replace("Li,0.2", "Li,"), "0,0,0,0,0,0\n" * 2, "Li"),
        (METADATA.replace("Li,0.2", "Li,200"), "0,0,0,0,0,0\n" * 2, "millimetres"),
        (METADATA.replace("N,2", "N,6"), "0,0,0,0,0,0\n" * 2, "expected N = 6"),
        (METADATA, "0,0,0,0,0\n" * 2, "expected rows"),
        (METADATA, "0,0,0,0,0,nan\n" * 2, "finite"),
        (METADATA, "a,b\n", "damaged"),
    ],
)
def test_damaged_sets_are_refused(tmp_path: Path, metadata: str, rows: str, words: str) -> None:
    """Each damage is one sentence with what was expected."""
    with pytest.raises(OptiOdomError, match=words):
        read_squares(folder(tmp_path, metadata, rows))


def test_a_truncated_gzip_is_refused_by_its_name(tmp_path: Path) -> None:
    """A file cut off in the middle is damaged, not short."""
    path = folder(tmp_path, rows="0,0,0,0,0,0\n" * 5000)
    run = path / "set_run-02.csv.gz"
    run.write_bytes(run.read_bytes()[:-20])
    with pytest.raises(OptiOdomError, match=r"set_run-02\.csv\.gz: damaged"):
        read_squares(path)


def test_runs_that_are_no_squares_are_refused(tmp_path: Path) -> None:
    """A straight drive does not turn once around."""
    with pytest.raises(DirectionError, match="not one square"):
        experiment_of_optiodom(folder(tmp_path))
