"""`omnimate drift`: one line, whatever it says."""

from omnimate.calib.monitoring.drift import DriftReport, MonitoredQuantity
from omnimate.cli.drift import verdict


def kind(since, highest, count=30, unit="m"):
    values = tuple([0.010] * (20 if since else count) + [0.055] * (count - 20 if since else 0))
    return MonitoredQuantity("return error of truck a, cw, y", unit, values, highest, 8.4, since)


def test_an_alarm_says_what_shifted_by_how_much_and_from_when_on():
    line = verdict(DriftReport((kind(None, 1.0), kind(21, 9.9)), 3, 2))
    assert line.startswith("calibrate again: return error of truck a, cw, y was +10.0 mm and is +55.0 mm")
    assert "from number 21 of 30 on (sum 9.9, alarm at 8.4)" in line
    assert "2 recording(s) from before the last calibration left out" in line


def test_a_healthy_robot_is_fine_and_what_is_nearest_to_an_alarm_is_said():
    assert verdict(DriftReport((kind(None, 5.1),), 2, 0)).startswith("fine: no shift in 1 kinds of numbers")


def test_too_few_laps_cannot_tell_and_say_how_many_are_needed(accepted, small_drive):
    result = accepted("drift", small_drive)
    assert result.out.startswith("cannot tell: 1 number(s) of a kind in 1 recording(s), and 6 are needed")
    assert result.out.count("\n") == 1


def test_nothing_watched_cannot_tell_either():
    assert verdict(DriftReport((), 1, 0)).startswith("cannot tell: 0 number(s)")
