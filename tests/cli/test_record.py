"""`omnimate record` with a flight recorder, on a simulated robot; `replay` of what it wrote."""

import json
import shutil

import can
import pytest
from typer.testing import CliRunner

from omnimate.cli.main import app
from omnimate.driver.bus.clock import SyncClock
from omnimate.driver.errors import BusError
from omnimate.files.recordings.folder import load_recording
from omnimate.vcan_sim.coupled_bus import CoupledBus
from omnimate.vcan_sim.faults import parse_fault
from omnimate.vcan_sim.plant import Plant
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.truth import Truth


@pytest.fixture(scope="module")
def flight(tmp_path_factory):
    """Return the folder of a flight recorder, of a robot of which an encoder restarts and a drive reports."""
    vehicle, place = reference_vehicle(), tmp_path_factory.mktemp("record")
    faults = [parse_fault(text) for text in ("reboot:node=3,at=1", "emcy:node=12,at=4")]
    bus = CoupledBus(vehicle, Plant(Truth(vehicle), vehicle), faults)
    call = ["record", f"{place}/drive", "--bus", "socketcan://can0", "--seconds", "8"]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("omnimate.driver.robot.driver.open_bus", lambda *_args: bus)
        patch.setattr("omnimate.driver.robot.driver.WallClock", lambda period: SyncClock(period, 1.7e9))
        result = CliRunner().invoke(app, [*call, "--flight-recorder", f"{place}/flights"])
    assert result.exit_code == 0, result.output
    (folder,) = (place / "flights").iterdir()
    return folder


def test_record_leaves_the_minute_before_a_fault_as_a_recording_that_other_commands_read(flight, omnimate):
    assert load_recording(flight).time[-1] == pytest.approx(1.7e9 + 1.3 + 5.0, abs=0.1)
    assert omnimate("dump", flight, "--kind", "emcy").out.count("\n") == 1


def test_replay_prints_frames_states_and_events_in_order_from_the_fault(flight, accepted):
    result = accepted("replay", flight)
    lines = result.out.splitlines()
    lines = lines[: next(number for number, line in enumerate(lines) if " frames: " in line)]
    times = [float(line.split()[0]) for line in lines]
    assert times == sorted(times)
    words = [" ".join(line.split()[2:]) for line in lines]
    order = [
        "703h node 3: boot-up",
        "fault node 3: restarted (boot-up)",
        "08Ch node 12: EMCY 5000h: device hardware (error register 01h)",
        "event node 12: EMCY 5000h: device hardware (error register 01h)",
    ]
    start = words.index(order[1])
    assert times[start] == 0.0
    assert [line for line in words[start - 1 :] if line in order] == order
    assert {"080h SYNC"} == {line for line in words if line.startswith("080h")}
    around = [time for time, line in zip(times, words, strict=True) if line == "080h SYNC"]
    assert -0.1 <= around[0] < -0.08
    assert 0.08 < around[-1] <= 0.1


def test_replay_prints_frames_and_commands_as_far_from_the_fault_as_asked(flight, omnimate, tmp_path):
    flight = shutil.copytree(flight, tmp_path / "flight")
    start = json.loads((flight / "events.jsonl").read_text().splitlines()[0])["time"]
    command = {"time": start + 1.0, "node": None, "what": "commanded a.left 1.0", "kind": "command"}
    with (flight / "events.jsonl").open("a") as file:
        file.write(json.dumps(command) + "\n")
    near, far = (omnimate("replay", flight, "--frames", seconds).out for seconds in (0, 2))
    assert "080h     SYNC" not in near
    assert "commanded" not in near
    assert far.count("080h     SYNC") > 100
    assert "commanded" in far


class Silent(can.BusABC):
    """A bus on which nothing is sent; time passes on it alone."""

    def __init__(self):
        self.now = 0.0
        super().__init__(channel="silent")

    def monotonic(self):
        return self.now

    def send(self, msg, timeout=None):
        raise AssertionError(msg)

    def recv(self, timeout=None):
        self.now += timeout


@pytest.mark.parametrize("seconds", [0.5, 2.0, 12.0])
def test_listening_to_a_bus_without_sync_ends_at_the_time_asked_for(omnimate, tmp_path, monkeypatch, seconds):
    bus = Silent()
    monkeypatch.setattr("omnimate.driver.robot.passive.open_bus", lambda *_args: bus)
    monkeypatch.setattr("omnimate.driver.robot.passive.time", bus)
    call = ("record", tmp_path / "drive", "--bus", "socketcan://can0", "--listen-only", "--seconds", seconds)
    result = omnimate(*call)
    assert (result.code, bus.now) == (1, seconds)
    assert f"no PDO of this vehicle within {seconds:g} s" in result.err
    assert "nothing was recorded" in result.err
    assert not (tmp_path / "drive").exists()


class Torn(CoupledBus):
    """The bus of a simulated vehicle whose cable is torn after so many SYNCs."""

    left = 300

    def send(self, msg, timeout=None):
        self.left -= msg.arbitration_id == 0x080
        if self.left < 0:
            raise can.CanOperationError("cable torn")
        super().send(msg, timeout)


class Paused(SyncClock):
    """A clock that notes the pauses, which take no time."""

    def __init__(self, period, start):
        super().__init__(period, start)
        self.paused = 0.0

    def sleep(self, seconds):
        self.paused += seconds


def test_a_lost_bus_is_waited_for_until_the_time_asked_for_and_what_came_before_is_kept(
    omnimate, tmp_path, monkeypatch
):
    vehicle, clocks = reference_vehicle(), []
    buses = [Torn(vehicle, Plant(Truth(vehicle), vehicle))]

    def opened(url, _bitrate):
        if not buses:
            raise BusError(url, "nobody answers")
        return buses.pop()

    def clock(period):
        clocks.append(Paused(period, 1.7e9))
        return clocks[-1]

    monkeypatch.setattr("omnimate.driver.robot.driver.open_bus", opened)
    monkeypatch.setattr("omnimate.driver.robot.driver.WallClock", clock)
    result = omnimate("record", tmp_path / "drive", "--bus", "socketcan://can0", "--seconds", 8)
    driven = 299 * vehicle.bus.sync_period
    assert clocks[0].paused == pytest.approx(8.0 - driven, abs=0.1)
    assert result.code == 1
    assert f"recording: {tmp_path / 'drive'}" in result.out
    assert "lost (cable torn), and not back within" in result.err
    assert load_recording(tmp_path / "drive").time[-1] == pytest.approx(1.7e9 + driven, abs=0.1)
