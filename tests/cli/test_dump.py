"""`omnimate dump`: lines as candump prints them, words behind them, rates, and honest exit codes."""

import gzip
import os
import signal
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import can
import pytest
import typer
from typer.testing import CliRunner

from omnimate.cli.dump import dump
from omnimate.files.logs.blocks import read_log
from omnimate.files.logs.formats import block_reader
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vehicle.file import save_vehicle
from tests.cli.conftest import ScriptedBus
from tests.samples import CANOPEN_TRACES, CAR_LOG, OTHER_ROBOT, OTHER_ROBOT_ASC, cases

LOG = """(1700000000.000250) can0 080#
(1700000000.000500) can0 181#409C0000
(1700000000.000750) can0 187#E8030000
(1700000000.001000) can0 701#05
(1700000000.001250) can0 083#1081000000000000
(1700000000.001500) can0 58A#8008100000000405
(1700000000.001750) can0 000#8102
(1700000000.002000) can0 2A3#00
(1700000000.002250) can0 7FF#00
(1700000000.002500) can0 00012345#00
(1700000000.002750) can0 185#0000
(1700000000.010250) can0 080#
"""
WORDS = [
    "SYNC",
    "a.left = 6.28319 rad (40000 counts)",
    "link = 1.1 m (1000 counts)",
    "heartbeat of node 1: operational (a.left)",
    "EMCY of node 3: 8110h CAN overrun, objects lost, error register 00h (b.left)",
    "SDO from node 10: abort of 1008h:00, 05040000h SDO protocol timed out (not of this vehicle)",
    "NMT reset node, node 2",
    "TPDO2 of node 35 (not of this vehicle)",
    "not CANopen: no such COB-ID or length in the predefined connection set",
    "not CANopen: 29-bit identifier",
    "joint_a: wrong length, 2 bytes",
    "SYNC",
]


def run(*arguments):
    """Run the verb; an error that it raises is in `result.exception`."""
    app = typer.Typer()
    app.command()(dump)
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture
def log(tmp_path):
    (tmp_path / "can.log").write_text(LOG)
    return tmp_path / "can.log"


@pytest.fixture
def vehicle(tmp_path, robot_toml):
    (tmp_path / "vehicle.toml").write_text(robot_toml)
    return tmp_path / "vehicle.toml"


def test_the_long_form_is_candumps(log):
    lines = run(log, "--form", "ta").stdout.splitlines()
    assert lines[1] == " (1700000000.000500)  can0  181   [4]  40 9C 00 00"
    assert lines[-1] == " (1700000000.010250)  can0       080   [0] "


def test_decoded_words_stand_behind_the_lines(log, vehicle):
    lines = run(log, "--decode", "--vehicle", vehicle).stdout.splitlines()
    assert [line.split("  ; ")[0] for line in lines] == LOG.splitlines()
    assert [line.split("  ; ")[1] for line in lines] == WORDS


def test_a_recording_folder_brings_its_own_vehicle(log, vehicle):
    lines = run(vehicle.parent, "--decode").stdout.splitlines()
    assert [line.split("  ; ")[1] for line in lines] == WORDS
    assert log.exists()


def test_rates_are_a_table_by_identifier(log, vehicle):
    lines = run(log, "--rates", "--vehicle", vehicle).stdout.splitlines()
    assert lines[0].split() == ["interface", "id", "frames", "Hz", "bytes", "name"]
    assert ["can0", "080", "2", "100.000", "0", "SYNC"] in [line.split() for line in lines]
    assert ["can0", "181", "1", "-", "4", "a.left"] in [line.split() for line in lines]
    assert ["can0", "00012345", "1", "-", "1", "not", "CANopen"] in [line.split() for line in lines]
    assert len(lines) == 12


def test_a_rate_is_that_of_the_time_in_which_frames_came_and_not_of_a_pause(log):
    """A heartbeat of 0.5 s, silent for an hour in between, has 2 Hz; a single pair has its distance."""
    times = [0.5 * step for step in range(20)]
    times += [3600.0 + time for time in times]
    log.write_text("".join(f"({1.7e9 + time:.6f}) can0 701#05\n" for time in times))
    assert run(log, "--rates").stdout.splitlines()[1].split()[:4] == ["can0", "701", "40", "2.000"]
    log.write_text("(1700000000.000000) can0 701#05\n(1700003600.000000) can0 701#05\n")
    assert run(log, "--rates").stdout.splitlines()[1].split()[3] == "0.000"


def body(log, *arguments):
    return [line.split() for line in run(log, *arguments).stdout.splitlines()]


def test_filters_keep_what_is_asked_for(log):
    assert [line[2] for line in body(log, "--id", "080")] == ["080#", "080#"]
    assert [line[2].split("#")[0] for line in body(log, "--node", 1)] == ["181", "701"]
    assert [line[2].split("#")[0] for line in body(log, "--kind", "emcy", "--kind", "nmt")] == ["083", "000"]
    assert len(body(log, "--id", "~080")) == 10
    assert [line[2] for line in body(log, "--from", 0.005)] == ["080#"]


def test_a_trigger_keeps_what_is_around_it_and_says_when(log, vehicle):
    result = run(log, "--trigger", "emcy", "--around", 0.0003)
    assert [line.split()[2].split("#")[0] for line in result.stdout.splitlines()] == ["701", "083", "58A"]
    assert "emcy: 1 times, at 0.001 s" in result.stderr
    result = run(log, "--trigger", "link>1.05", "--around", 0, "--vehicle", vehicle)
    assert [line.split()[2].split("#")[0] for line in result.stdout.splitlines()] == ["187"]


def test_times_as_of_candump_td_and_tz(log):
    lines = LOG.splitlines(keepends=True)
    log.write_text(lines[0] + lines[1] + lines[3])
    assert [line[0] for line in body(log, "--form", "td")] == ["(000.000000)", "(000.000250)", "(000.000500)"]
    assert [line[0] for line in body(log, "--form", "tz")] == ["(000.000000)", "(000.000250)", "(000.000750)"]


def test_a_dbc_and_an_eds_name_the_values(log, tmp_path):
    dbc = tmp_path / "bus.dbc"
    dbc.write_text('BO_ 391 link: 4 x\n SG_ rod : 0|32@1+ (0.001,0) [0|0] "m" x\n')
    eds = Path(__file__).parents[2] / "vcan_sim" / "eds" / "encoder_cia406.eds"
    lines = run(log, "--decode", "--dbc", dbc, "--eds", f"1={eds}").stdout.splitlines()
    assert lines[2].endswith("; rod = 1 m")
    assert lines[1].endswith("; 1.6004h Position value = 40000")


def test_the_mapping_that_the_log_shows_names_the_values(log):
    mapping = "(1700000000.000100) can0 601#23001A0120000460\n"
    log.write_text(mapping + LOG)
    assert run(log, "--decode").stdout.splitlines()[2].endswith("; 1.6004h Position value = 40000")


def test_count_ends_early(log):
    assert run(log, "--count", 2).stdout == "".join(LOG.splitlines(keepends=True)[:2])


MESSAGES = [
    can.Message(at, can_id, is_extended_id=False, data=data, channel="can0")
    for at, can_id, data in (
        (1700000000.00025, 0x080, b""),
        (1700000000.0005, 0x181, b"\x40\x9c\0\0"),
        (1700000000.01025, 0x080, b""),
    )
]
LIVE = "(1700000000.000250) can0 080#\n(1700000000.000500) can0 181#409C0000\n(1700000000.010250) can0 080#\n"


@pytest.fixture
def live(monkeypatch):
    """Run the verb on a scripted bus, as from a terminal: a shell's background jobs ignore Ctrl-C."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    signal.signal(signal.SIGINT, signal.default_int_handler)

    def run_live(*arguments, messages=MESSAGES, then=lambda: None):
        bus = ScriptedBus(messages, then)
        monkeypatch.setattr("omnimate.driver.bus.bus.open_bus", lambda _url: bus)
        result = run("--bus", "virtual://test", *arguments)
        assert bus.closed
        return result

    yield run_live
    for number, handler in before.items():
        signal.signal(number, handler)


def test_a_live_bus_is_printed_until_it_is_enough(live):
    result = live("--count", 3)
    assert (result.stdout, result.exit_code) == (LIVE, 0)


def test_a_silent_bus_ends_with_its_time(live):
    result = live("--seconds", "0")
    assert (result.stdout, result.exit_code) == ("", 0)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signals_end_it_in_good_order(live, number):
    result = live("--rates", then=lambda: signal.raise_signal(number))
    assert result.exit_code == 0
    assert result.stdout.splitlines()[1].split() == ["can0", "080", "2", "100.000", "0", "SYNC"]


def test_live_words_and_the_long_form(live, vehicle):
    result = live("--decode", "--vehicle", vehicle, "--form", "ta", "--count", 2)
    assert result.stdout.splitlines()[1] == (
        " (1700000000.000500)  can0  181   [4]  40 9C 00 00  ; a.left = 6.28319 rad (40000 counts)"
    )


FD_LOG = """\
(1700000000.000000) can0 181#0011223344556677
(1700000000.000100) can0 181##1000102030405060708090A0B
(1700000000.000200) can1 12345678##200
(1700000000.000300) can0 701#05
"""


@pytest.mark.parametrize("end", ["\n", ""])
def test_can_fd_of_a_log_is_printed_as_it_was(log, end):
    log.write_text(FD_LOG.rstrip() + end)
    result = run(log)
    assert (result.exit_code, result.stdout, result.stderr) == (0, FD_LOG, "")


def test_can_fd_is_shown_in_the_long_form_in_words_and_with_its_own_rate(log):
    log.write_text(FD_LOG)
    assert run(log, "--form", "ta").stdout.splitlines()[1] == (
        " (1700000000.000100)  can0  181  [12]  00 01 02 03 04 05 06 07 08 09 0A 0B"
    )
    assert "0A0B  ; not CANopen: a CAN FD frame" in run(log, "--decode").stdout
    rates = [line.split()[:5] for line in run(log, "--rates").stdout.splitlines()]
    assert ["can0", "181", "1", "-", "8"] in rates
    assert ["can0", "181", "1", "-", "12"] in rates
    assert run(log, "--kind", "pdo").stdout == FD_LOG.splitlines(keepends=True)[0]


def fail():
    raise can.CanOperationError("the cable is out")


def test_a_bus_that_is_lost_ends_the_dump_with_a_sentence(live):
    result = live(then=fail)
    assert result.stdout == LIVE
    assert "virtual://test: the bus interface failed: the cable is out" in result.stderr


def test_can_fd_of_a_live_bus_is_printed(live):
    fd = can.Message(1.7e9, 1, is_extended_id=False, is_fd=True, data=range(12), channel="can0")
    result = live("--count", 4, messages=[fd, *MESSAGES])
    assert result.stdout == "(1700000000.000000) can0 001##0000102030405060708090A0B\n" + LIVE
    assert not result.stderr


@pytest.mark.parametrize("path", cases(OTHER_ROBOT_ASC, *CANOPEN_TRACES))
def test_canopen_traces_are_described_frame_by_frame(path):
    result = run(path, "--decode")
    assert result.exit_code == 0
    lines = result.stdout.splitlines()
    assert len(lines) == len(read_log(path).frames)
    assert all("  ; " in line for line in lines)
    foreign = [line for line in lines if "not CANopen" in line]
    assert all(line.split()[2].split("#")[0] in {"10A", "7EA"} for line in foreign)


@pytest.mark.parametrize("path", cases(OTHER_ROBOT, CAR_LOG))
def test_a_strangers_log_is_dumped_byte_for_byte_and_reported_as_foreign(path, tmp_path, robot_toml):
    result = run(path)
    assert result.exit_code == 0
    content = path.read_bytes()
    assert result.stdout_bytes == (gzip.decompress(content) if path.suffix == ".gz" else content)
    (tmp_path / "vehicle.toml").write_text(robot_toml)
    words = run(path, "--decode", "--vehicle", tmp_path / "vehicle.toml", "--count", 2000).stdout.splitlines()
    assert len(words) == min(2000, len(read_log(path).frames))
    assert not any(" counts)" in line for line in words)
    assert sum("not of this vehicle" in line or "not CANopen" in line for line in words) > 0.9 * len(words)


def test_a_live_bus_is_filtered_too_and_has_no_triggers(live):
    assert live("--id", "181", "--count", 1).stdout == LIVE.splitlines(keepends=True)[1]
    assert "needs a log" in str(run("--bus", "virtual://x", "--trigger", "emcy").exception)


def test_live_times_as_of_candump_td(live):
    lines = live("--form", "td", "--count", 3).stdout.splitlines()
    assert [line.split()[0] for line in lines] == ["(000.000000)", "(000.000250)", "(000.009750)"]


def test_a_vehicle_names_the_eds_of_its_nodes_and_one_that_is_gone_is_a_warning(log, tmp_path):
    eds = Path(__file__).parents[2] / "vcan_sim" / "eds" / "drive_cia402.eds"
    robot = reference_vehicle()
    named = replace(robot, drives=(replace(robot.drives[0], eds=str(eds)), *robot.drives[1:]))
    other = tmp_path / "status.log"
    other.write_text("(1.000000) can0 18B#3702\n")
    save_vehicle(named, tmp_path / "vehicle.toml")
    call = (other, "--decode", "--vehicle", tmp_path / "vehicle.toml")
    assert "11.6041h" in run(*call).stdout
    gone = replace(robot, drives=(replace(robot.drives[0], eds="gone.eds"), *robot.drives[1:]))
    save_vehicle(gone, tmp_path / "vehicle.toml")
    result = run(*call)
    assert "gone.eds: not there" in result.stderr
    assert result.exit_code == 0


@pytest.mark.parametrize(
    "options",
    [
        (),
        ("--form", "ta"),
        ("--form", "td"),
        ("--form", "tz", "--id", "180-1FF"),
        ("--decode",),
        ("--rates",),
        ("--trigger", "gap:0.005", "--around", "0.002", "--form", "td", "--decode"),
        ("--trigger", "emcy", "--around", "0.001", "--count", "40"),
        ("--from", "0.1", "--to", "0.3", "--count", "70"),
    ],
)
def test_a_log_that_is_read_in_small_blocks_is_printed_as_at_once(log, monkeypatch, options):
    lines = [line for line in LOG.splitlines(keepends=True) if "00012345" not in line]
    shifted = [
        f"({1700000000 + 0.02 * n + float(line[11:18]):.6f}){line[19:]}" for n in range(60) for line in lines
    ]
    long = f"{shifted[500].split()[0]} can0 00012345#00\n"
    log.write_text("".join([*shifted[:500], long, *shifted[500:]]))
    at_once = run(log, *options)
    assert at_once.exit_code == 0, at_once.output
    monkeypatch.setattr(block_reader.BlockReader.__init__, "__defaults__", (512,))
    in_blocks = run(log, *options)
    assert (in_blocks.stdout, in_blocks.stderr) == (at_once.stdout, at_once.stderr)
    assert len(in_blocks.stdout.splitlines()) > 9


def test_a_pipe_is_read_once_and_a_trigger_asks_for_a_file(log, tmp_path):
    for content in (LOG.encode(), gzip.compress(LOG.encode())):
        pipe = tmp_path / "pipe"
        os.mkfifo(pipe)
        with ThreadPoolExecutor(1) as pool:
            written = pool.submit(pipe.write_bytes, content)
            assert run(pipe, "--decode").stdout == run(log, "--decode").stdout
            written.result()
        refused = run(pipe, "--trigger", "emcy")
        assert "needs a log that is a file" in str(refused.exception)
        pipe.unlink()


def test_a_file_without_a_frame_is_an_error_in_all_forms(tmp_path):
    path = tmp_path / "passwd"
    path.write_text("root:x:0:0:root:/root:/bin/bash\n" * 9)
    for options in ((), ("--rates",), ("--decode",), ("--trigger", "emcy")):
        assert "passwd:1: no CAN frame in the whole file" in str(run(path, *options).exception)
