"""What a driver found is told whole, however narrow the screen is."""

import pytest

from omnimate.cli.console import out
from omnimate.cli.driver_reports import COUNTERS, show_configuration, show_report
from omnimate.driver.canopen.node_setup import NodeConfiguration
from omnimate.driver.robot.bus_load import BusLoad
from omnimate.driver.robot.configure import ConfigurationReport
from omnimate.driver.robot.report import DriverReport, NodeReport
from omnimate.vcan_sim.reference import reference_vehicle

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


def test_no_cell_of_the_configuration_is_folded_into_a_pipe(capsys):
    remark = "TPDO2 281h stays on, its frames count as unknown: " + 9 * "a long reason of the device, "
    node = NodeConfiguration(1, ("a.left",), remarks=[remark])
    show_configuration(ConfigurationReport((node,), BusLoad(500_000, 0.1, 0.2), reference_vehicle()))
    assert remark.strip() in capsys.readouterr().out
