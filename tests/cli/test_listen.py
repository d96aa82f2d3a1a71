"""`omnimate listen` on logs and on a live bus."""

import json

import cantools
import pytest

from omnimate.files.logs.formats.candump_lines import format_lines
from omnimate.files.logs.formats.python_can_logs import message_of_frame
from tests.cli.conftest import ScriptedBus
from tests.listen.conftest import robot_log


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    path = tmp_path_factory.mktemp("listen") / "can.log"
    path.write_text("\n".join([*format_lines(robot_log(), "log", 17), ""]))
    return path


def test_a_log_gives_a_dbc_a_draft_a_report_and_pictures(accepted, log, tmp_path):
    folder = tmp_path / "found"
    result = accepted("listen", log, "--write", folder, "--turn", "left")
    assert "wheel_1_0" in result.out
    assert cantools.database.load_file(folder / "bus.dbc").messages
    assert 'channel = "a.left"' in (folder / "vehicle.toml").read_text()
    assert (folder / "185.png").stat().st_size > 1000
    assert "sure" in (folder / "report.txt").read_text()


def test_a_draft_is_never_overwritten_which_is_said_before_listening(refused, tmp_path):
    """A log without frames is refused only when it is read."""
    (tmp_path / "vehicle.toml").write_text("mine")
    (tmp_path / "empty.log").touch()
    assert "exists already" in refused("listen", tmp_path / "empty.log", "--write", tmp_path)
    assert (tmp_path / "vehicle.toml").read_text() == "mine"


def test_json_is_all_that_is_printed_and_the_option_of_older_scripts_still_works(omnimate, log):
    result = omnimate("listen", log, "--json")
    assert {message["can_id"] for message in json.loads(result.out)["messages"]} == {0x185, 0x186, 0x286}
    assert omnimate("listen", "--log", log, "--json") == result
    assert "--log" not in omnimate("listen", "--help").out


def test_a_live_bus_is_heard_and_nothing_is_sent(accepted, monkeypatch):
    def interrupt():
        raise KeyboardInterrupt

    bus = ScriptedBus(map(message_of_frame, robot_log()), interrupt)
    monkeypatch.setattr("omnimate.driver.bus.bus.open_bus", lambda _url: bus)
    result = accepted("listen", "--bus", "virtual://x")
    assert "nothing was sent" in result.out
    assert "wheel 2" in result.out


def test_no_period_is_stated_of_a_message_that_was_sent_once(accepted, tmp_path):
    (tmp_path / "can.log").write_text("(1700000000.000000) can0 185#409C0000\n")
    result = accepted("listen", tmp_path / "can.log")
    assert "sent once" in result.out
    assert "every" not in result.out
