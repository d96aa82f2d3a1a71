"""The parsers that `python -m studies.fuzz` searches; here without coverage guidance."""

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.vehicle.errors import OmnimateError
from studies.fuzz import PARSERS, Parser, Search

SEEDS = {name: parser.seeds() for name, parser in PARSERS.items()}


@pytest.mark.parametrize("name", PARSERS)
def test_a_seed_is_read_without_an_error(name, tmp_path):
    for content in SEEDS[name]:
        (tmp_path / PARSERS[name].name).write_bytes(content)
        PARSERS[name].read(tmp_path / PARSERS[name].name)


@pytest.mark.parametrize("name", PARSERS)
@given(data=st.data())
def test_a_changed_file_is_read_or_refused_by_a_documented_error(name, data, tmp_path):
    content = bytearray(data.draw(st.sampled_from(SEEDS[name])))
    for _ in range(data.draw(st.integers(1, 4))):
        start = data.draw(st.integers(0, len(content)))
        end = min(len(content), start + data.draw(st.integers(0, 8)))
        content[start:end] = data.draw(st.binary(max_size=8))
    path = tmp_path / PARSERS[name].name
    path.write_bytes(content)
    with suppress(OmnimateError):
        PARSERS[name].read(path)


def test_a_search_counts_crashes_by_their_place_and_no_documented_error(tmp_path):
    def read(path):
        text = path.read_bytes()
        if text == b"documented":
            raise OmnimateError("a sentence")
        return int(text)

    ended = []
    search = Search(Parser(read, list), tmp_path / "input", inputs=4, finished=ended.append)
    for content in (b"1", b"documented", b"x", b"y"):
        assert not ended
        search.try_input(content)
    assert ended == [search]
    assert (search.accepted, search.count, search.hangs) == (1, 4, [])
    assert list(search.crashes.values()) == [b"x"]
