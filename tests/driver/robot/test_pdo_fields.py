"""A field of a PDO reads the same live, number by number, and offline, a log at a time."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from omnimate.driver.robot.pdo_fields import field_of
from omnimate.files.logs.pdo_fields import decode
from omnimate.vehicle.parameters import Encoder


@given(
    st.integers(1, 64).flatmap(lambda bits: st.tuples(st.just(bits), st.integers(0, 64 - bits))),
    st.booleans(),
    st.lists(st.integers(0, 2**64 - 1), min_size=1, max_size=5),
)
def test_live_and_offline_decode_alike(place, signed, words):
    bits, start = place
    encoder = Encoder("a.left", 1, 0x181, start, bits, signed=signed, sign=1, counts_per_turn=100.0)
    live = [field_of(encoder, 0).decode(word) for word in words]
    offline = decode(np.array(words, np.uint64), encoder)
    wrapped = [(value + 2**63) % 2**64 - 2**63 for value in live]
    assert offline.astype(np.int64).tolist() == wrapped
