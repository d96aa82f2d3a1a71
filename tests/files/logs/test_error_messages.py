"""The messages for broken logs and recordings, word for word, as the tables under `tests/data/` say."""

from pathlib import Path

import pytest

from omnimate.files.logs.formats.candump_lines import parse_line
from omnimate.files.logs.formats.minimon import read_trace
from omnimate.files.recordings.poses_csv import read_poses
from omnimate.files.recordings.run_toml import read_run
from omnimate.vehicle.errors import RecordingError
from tests.samples import broken

MINIMON_HEAD = 'ASCII Trace IXXAT MiniMon V3\n"Time";"Identifier (hex)";"Format";"Flags";"Data (hex)"\n'


def cases(table):
    rows = [(case["input"], case["message"]) for case in broken(f"logs/{table}")]
    return pytest.mark.parametrize(("text", "message"), rows)


@cases("broken_candump_lines.toml")
def test_a_candump_line_without_a_frame_is_skipped_with_its_reason(text, message):
    assert parse_line(text.encode()) == message


@cases("broken_minimon_lines.toml")
def test_a_minimon_line_without_a_frame_is_skipped_with_its_reason(text, message):
    entries = list(read_trace((MINIMON_HEAD + text).splitlines(keepends=True)))
    assert [(entry.line, entry.reason) for entry in entries] == [(3, message)]


@cases("broken_poses.toml")
def test_broken_poses_are_answered_with_file_line_and_expectation(tmp_path, monkeypatch, text, message):
    monkeypatch.chdir(tmp_path)
    Path("lap").mkdir()
    Path("lap/poses.csv").write_text(text, encoding="utf-8")
    with pytest.raises(RecordingError) as caught:
        read_poses("lap/poses.csv", ("a",))
    assert str(caught.value) == message


@cases("broken_runs.toml")
def test_a_broken_run_is_answered_with_file_key_and_expectation(tmp_path, monkeypatch, text, message):
    monkeypatch.chdir(tmp_path)
    Path("run.toml").write_text(text, encoding="utf-8")
    with pytest.raises(RecordingError) as caught:
        read_run("run.toml")
    assert str(caught.value) == message
