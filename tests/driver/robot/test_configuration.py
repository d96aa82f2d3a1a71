"""The wrap range, from what `vehicle.toml` states and what the device reports in 6002h."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from omnimate.driver.robot.configure import choose_range
from omnimate.vehicle.parameters import Encoder

widths = st.integers(8, 32)


def encoder(bits, **changes):
    return Encoder("a.left", 1, 0x181, 0, bits, signed=False, sign=1, counts_per_turn=4096.0, **changes)


@given(widths, st.one_of(st.none(), st.integers(0, 2**32 - 1)), st.booleans())
def test_the_chosen_range_never_exceeds_the_field_and_is_stated(bits, reported, is_stated):
    wheel = encoder(bits, **({"range": 2 ** (bits - 1)} if is_stated else {}))
    chosen, reason = choose_range(wheel, reported)
    assert 1 < chosen <= 2**bits
    assert reason.startswith("a.left: ")
    assert str(chosen) in reason or "2**32" in reason


@given(widths, st.integers(0, 2**32 - 1))
def test_a_range_in_vehicle_toml_always_wins(bits, reported):
    wheel = encoder(bits, range=2 ** (bits - 1))
    assert choose_range(wheel, reported)[0] == 2 ** (bits - 1)


@given(st.integers(2, 31))
def test_a_vendor_that_means_n_and_one_that_means_n_minus_1_give_the_same_range(exponent):
    wheel = encoder(32)
    assert choose_range(wheel, 2**exponent)[0] == choose_range(wheel, 2**exponent - 1)[0] == 2**exponent


@given(widths)
def test_a_device_that_reports_nothing_wraps_as_vehicle_toml_says(bits):
    wheel = encoder(bits)
    assert choose_range(wheel, None)[0] == wheel.wrap_range
