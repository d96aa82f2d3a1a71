"""Lists of `key=value`."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.vcan_sim.key_values import BYTES, INTEGER, NUMBER, TEXT, read_values

KINDS = {"x": NUMBER, "n": INTEGER, "name": TEXT, "data": BYTES}


@given(st.floats(allow_nan=False), st.integers(), st.binary(max_size=8))
def test_values_come_back_as_they_were_written(number, whole, data):
    text = f"x={number},n={whole},data={data.hex()}"
    assert read_values(text, KINDS, ValueError) == {"x": number, "n": whole, "data": data.hex()}


@pytest.mark.parametrize("text", ["n=16", "n=0x10", "n=0b10000"])
def test_an_integer_may_be_written_in_any_base(text):
    assert read_values(text, KINDS, ValueError) == {"n": 16}
