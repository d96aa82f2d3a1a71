"""Tables of tape-measured return errors."""

from pathlib import Path

import numpy as np
import pytest

from omnimate.calib.errors import ReturnTableError
from omnimate.calib.umbmark.experiment import read_table

GOOD = """# measured on Tuesday
direction,x_mm,y_mm,theta_deg
cw,-152,-148,-1.9

cw,-139,-160,
CCW,305,-298,2.7
ccw , 310, -287, 2.5
"""


def write(folder: Path, text: str) -> Path:
    path = folder / "returns.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_millimetres_and_degrees(tmp_path: Path) -> None:
    """Units come from the header; comments, empty lines, spaces and missing headings are accepted."""
    errors = read_table(write(tmp_path, GOOD), 4.0)
    assert errors.cw == pytest.approx(
        np.array([[-0.152, -0.148, np.radians(-1.9)], [-0.139, -0.160, np.nan]]), nan_ok=True
    )
    assert errors.ccw[1] == pytest.approx([0.310, -0.287, np.radians(2.5)])
    assert errors.side == 4.0


@pytest.mark.parametrize(
    ("header", "scale", "turn"),
    [
        ("x_m,y_m,theta_rad", 1.0, 1.0),
        ("x_cm,y_cm,theta_deg", 100.0, 180.0 / np.pi),
        ("x_mm,y_m,theta_rad", 0, 1),
    ],
)
def test_units_mean_the_same_errors(tmp_path: Path, header: str, scale: float, turn: float) -> None:
    """The same runs in other units are the same return errors."""
    x, y = (scale, scale) if scale else (1000.0, 1.0)
    lines = [f"cw,{-0.15 * x},{-0.15 * y},{-0.03 * turn}", f"ccw,{0.3 * x},{-0.3 * y},{0.04 * turn}"]
    errors = read_table(write(tmp_path, f"direction,{header}\n" + "\n".join(lines)), 4.0)
    assert errors.cw[0] == pytest.approx([-0.15, -0.15, -0.03])
    assert errors.ccw[0] == pytest.approx([0.3, -0.3, 0.04])


def test_columns_in_any_order_and_no_heading(tmp_path: Path) -> None:
    """Only direction, x and y are needed; a byte-order mark from a spreadsheet does no harm."""
    text = "\ufeffy_mm,x_mm,direction\n-150,-140,cw\n-300,310,ccw\n"
    errors = read_table(write(tmp_path, text), 4.0)
    assert errors.cw[0] == pytest.approx([-0.14, -0.15, np.nan], nan_ok=True)


def test_an_error_carries_its_line_and_column(tmp_path: Path) -> None:
    """The messages are held word for word in `return_tables.toml`."""
    with pytest.raises(ReturnTableError) as caught:
        read_table(write(tmp_path, "direction,x_mm,y_mm\n#\ncw,1,two\n"), 4.0)
    assert (caught.value.line, caught.value.column) == (3, 3)


def test_a_file_that_is_not_text_is_refused(tmp_path: Path) -> None:
    """Bytes that are no UTF-8 are an error with the file's name, and so is no file."""
    path = tmp_path / "returns.csv"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ReturnTableError, match="cannot be read"):
        read_table(path, 4.0)
    with pytest.raises(ReturnTableError, match="cannot be read"):
        read_table(tmp_path / "nowhere.csv", 4.0)
