"""Values of objects: what is written as text is read as the same value."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.driver.canopen.eds import load_eds
from omnimate.driver.canopen.object_values import INTEGERS, ValueTextError, decode, encode, kind_of
from tests.driver.conftest import DEVICE_TYPE


@given(kind=st.sampled_from(sorted(INTEGERS)), data=st.data())
def test_integers(kind, data):
    bits = int(kind[1:])
    low, high = (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) if kind[0] == "i" else (0, 2**bits - 1)
    value = data.draw(st.integers(low, high))
    assert decode(encode(str(value), kind), kind) == value
    for outside in (low - 1, high + 1):
        with pytest.raises(ValueTextError, match=f"is no {kind}"):
            encode(str(outside), kind)


@given(value=st.floats(allow_nan=False), text=st.text(st.characters(exclude_characters="\0", codec="utf-8")))
def test_floats_text_and_bytes(value, text):
    assert decode(encode(repr(value), "f64"), "f64") == value
    assert decode(encode(text, "text"), "text") == text
    raw = text.encode()
    assert bytes.fromhex(str(decode(encode(raw.hex(), "hex"), "hex"))) == raw


@given(data=st.binary(max_size=8))
def test_what_is_not_known_is_a_small_number_or_bytes(data):
    value = decode(data, None)
    assert value == (int.from_bytes(data, "little") if len(data) <= 4 else data.hex(" ").upper())


@pytest.mark.parametrize("data_type", ["0xA", "0xB", "0xF"])
def test_octet_strings_unicode_strings_and_domains_are_bytes_even_if_short(tmp_path, data_type):
    path = tmp_path / "device.eds"
    path.write_text(DEVICE_TYPE + DEVICE_TYPE.replace("[1000]", "[2000]").replace("0x0007", data_type))
    kind = kind_of(load_eds(path, 5).dictionary, 0x2000, 0)
    assert decode(b"\x01\x02", kind) == "01 02"
