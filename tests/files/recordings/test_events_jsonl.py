import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.files.recordings.events_jsonl import RecordedEvent, read_events, write_events
from omnimate.vehicle.errors import RecordingError

EVENTS = st.lists(
    st.builds(
        RecordedEvent,
        st.floats(0.0, 1e10),
        st.none() | st.integers(1, 127),
        st.text(),
        st.sampled_from(["event", "fault", "command"]),
    )
)


@given(events=EVENTS)
def test_what_is_written_is_read_again_in_the_order_of_the_times(events, tmp_path_factory):
    path = tmp_path_factory.mktemp("events") / "events.jsonl"
    write_events(events, path)
    assert read_events(path) == tuple(sorted(events, key=lambda event: event.time))


def test_a_byte_order_mark_is_no_part_of_the_first_event(tmp_path):
    path = tmp_path / "events.jsonl"
    path.write_text('{"time": 1, "node": null, "what": "bus-off"}\n', encoding="utf-8-sig")
    assert read_events(path) == (RecordedEvent(1.0, None, "bus-off"),)


@pytest.mark.parametrize(
    "line",
    [
        "",
        "[1]",
        "{",
        '{"time": 1}',
        '{"time": "x", "node": 1, "what": ""}',
        '{"other": 1}',
        pytest.param(f'{{"time": 1{"0" * 400}, "node": 1, "what": ""}}', id="beyond all floats"),
        pytest.param("[" * 100_000, id="too deep"),
    ],
)
def test_a_line_that_is_no_event_is_named(tmp_path, line):
    path = tmp_path / "events.jsonl"
    path.write_text(f'{{"time": 1, "node": null, "what": "boot-up"}}\n{line}\n')
    with pytest.raises(RecordingError, match=r"events\.jsonl:2: expected an object with time, node"):
        read_events(path)


def test_a_file_that_cannot_be_read_is_named(tmp_path):
    with pytest.raises(RecordingError, match="cannot be read"):
        read_events(tmp_path / "events.jsonl")
