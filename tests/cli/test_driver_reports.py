"""What a driver found is told whole, however narrow the screen is."""

import pytest

from omnimate.cli.console import out
from omnimate.cli.driver_reports import COUNTERS, show_report
from omnimate.driver.robot.report import DriverReport, NodeReport

LARGE = 7_654_321


@pytest.mark.parametrize("width", [40, 80, 200])
def test_no_count_is_cut_at_any_width(capsys, monkeypatch, width):
    monkeypatch.setattr(out, "width", width)
    counts = [LARGE + step for step in range(9)]
    names = ("a.left", "drive of a.left")
    node = NodeReport(
        node=17, names=names, state="pre-operational", **dict(zip(COUNTERS, counts, strict=True))
    )
    show_report(DriverReport(0.0, LARGE, 3, (node,), (), 0, (), ()))
    words = capsys.readouterr().out.split()
    assert [word for word in words if word.isdigit()] == [*map(str, (LARGE, 17, *counts))]
