"""Fields of a PDO: bits become counts, and counts become bits again."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from omnimate.files.logs.pdo_fields import decode, encode
from omnimate.vehicle.parameters import Encoder


def encoder_of(start_bit, bits, signed, **changes):
    return Encoder("a.left", 1, 0x181, start_bit, bits, signed, 1, counts_per_turn=4096.0, **changes)


@given(
    start=st.integers(0, 63),
    bits=st.integers(1, 64),
    signed=st.booleans(),
    word=st.integers(0, 2**64 - 1),
)
def test_a_field_is_decoded_as_its_bits_say(start, bits, signed, word):
    bits = min(bits, 64 - start)
    encoder = encoder_of(start_bit=start, bits=bits, signed=signed)
    raw = (word >> start) & (2**bits - 1)
    expected = raw - 2**bits if signed and raw >> (bits - 1) else raw
    (decoded,) = decode(np.array([word], np.uint64), encoder).tolist()
    assert decoded % 2**64 == expected % 2**64


@given(
    bits=st.integers(2, 32),
    signed=st.booleans(),
    short=st.integers(0, 1000),
    count=st.integers(-(10**12), 10**12),
)
def test_counts_wrap_at_their_range_on_the_bus(bits, signed, short, count):
    wrap_range = max(2, 2**bits - short)
    encoder = encoder_of(start_bit=7, bits=bits, signed=signed, range=wrap_range)
    (raw,) = decode(encode(np.array([count]), encoder), encoder).tolist()
    assert (raw - count) % wrap_range == 0
    assert -wrap_range // 2 <= raw < wrap_range
