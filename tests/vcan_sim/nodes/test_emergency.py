"""Emergencies: EMCY messages, the error register and the error history."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.vcan_sim.errors import Abort, SdoAbort
from omnimate.vcan_sim.nodes.emergency import HEARTBEAT_ERROR, LENGTH_ERROR, Emergency


def errors_of(*calls):
    sent = []
    emergency = Emergency(sent.append)
    for name, code in calls:
        getattr(emergency, name)(code)
    return emergency, sent


def test_an_error_is_reported_when_it_begins_and_not_again():
    emergency, sent = errors_of(("set", LENGTH_ERROR), ("set", LENGTH_ERROR))
    assert sent == [b"\x10\x82\x11" + bytes(5)]  # 8210h; generic and communication error
    assert emergency.register == 0x11


def test_the_end_of_the_last_error_is_reported_by_code_0():
    emergency, sent = errors_of(
        ("set", LENGTH_ERROR), ("set", HEARTBEAT_ERROR), ("clear", LENGTH_ERROR), ("clear", HEARTBEAT_ERROR)
    )
    assert [data[:2] for data in sent] == [b"\x10\x82", b"\x30\x81", b"\0\0"]
    assert emergency.register == 0


@given(st.lists(st.integers(1, 0xFFFF), unique=True, max_size=20))
def test_the_history_has_the_last_eight_errors_the_newest_first(codes):
    emergency, _ = errors_of(*(("set", code) for code in codes))
    newest = codes[::-1][:8]
    assert [emergency.history(sub) for sub in range(1, len(newest) + 1)] == newest
    assert emergency.history(0) == len(newest)
    with pytest.raises(SdoAbort) as caught:
        emergency.history(len(newest) + 1)
    assert caught.value.code == Abort.NO_DATA


def test_only_a_write_of_0_erases_the_history():
    emergency, _ = errors_of(("set", 0x5000))
    with pytest.raises(SdoAbort):
        emergency.erase_history(1)
    assert emergency.history(0) == 1
    emergency.erase_history(0)
    assert emergency.history(0) == 0
