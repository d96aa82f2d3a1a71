"""A recording folder from a log of another tool: every classical frame, and the robot as it was described."""

import pytest

from omnimate.files.importers.bus_log import import_log
from omnimate.files.logs.blocks import LogStream
from omnimate.files.logs.frames import FD, Frame
from omnimate.files.logs.recording_to_frames import frames_of_recording
from omnimate.files.recordings.folder import load_recording
from omnimate.vehicle.errors import RecordingError
from tests.files.logs.any_frames import write_log


@pytest.fixture
def capture(drive, tmp_path):
    """The bus of a drive as a capture of Wireshark, with a CAN FD frame at its end."""
    last = Frame(float(drive.time[-1]) + 1.0, 0x181, bytes(12), FD)
    write_log([*frames_of_recording(drive), last], tmp_path / "bus.pcapng", ".pcapng")
    return tmp_path / "bus.pcapng"


def test_the_recording_has_the_counts_of_the_drive_and_is_not_written_over(capture, drive, tmp_path):
    assert import_log(LogStream(capture), drive.vehicle, tmp_path / "new", lambda _done, _total: None) == 1
    again = load_recording(tmp_path / "new")
    assert again.counts.tolist() == drive.counts.tolist()
    assert again.vehicle == drive.vehicle
    with pytest.raises(RecordingError, match=r"it holds a recording \(can.log\)"):
        import_log(LogStream(capture), drive.vehicle, tmp_path / "new", lambda _done, _total: None)
