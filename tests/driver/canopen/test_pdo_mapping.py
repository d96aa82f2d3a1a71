"""PDO mapping: entries as numbers and back, and every planned PDO holds its fields."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.driver.canopen.pdo_mapping import Entry, holds, length, plan, position_objects
from omnimate.driver.errors import MappingImpossible
from omnimate.vehicle.parameters import Encoder

NAMES = ("a.left", "a.right", "b.left")
profiles = st.sampled_from(["cia406", "cia402"])


@given(st.integers(0, 0xFFFF), st.integers(0, 0xFF), st.integers(0, 0xFF))
def test_an_entry_is_the_same_after_its_number(index, subindex, bits):
    entry = Entry(index, subindex, bits)
    assert Entry.of(entry.value) == entry
    assert entry.value < 2**32


@st.composite
def encoders_of_one_pdo(draw):
    """Draw one to three encoders of one PDO, with gaps of whole bytes."""
    profile, bit, encoders = draw(profiles), 0, []
    for name in NAMES[: draw(st.integers(1, 3))]:
        bit += 8 * draw(st.integers(0, 2))
        bits = draw(st.sampled_from([8, 16]))
        if bit + bits > 64:
            break
        encoders.append(
            Encoder(name, 1, 0x181, bit, bits, signed=False, sign=1, counts_per_turn=100.0, profile=profile)
        )
        bit += bits
    return draw(st.permutations(encoders))


@given(encoders_of_one_pdo(), st.data())
def test_a_planned_pdo_holds_every_field_whichever_alternatives_the_device_takes(encoders, data):
    objects = position_objects(encoders)
    slots = plan(encoders, objects)
    entries = [data.draw(st.sampled_from(alternatives)) for alternatives in slots]
    assert holds(entries, encoders, objects)
    assert 8 * length(entries) == max(encoder.start_bit + encoder.bits for encoder in encoders)


@given(encoders_of_one_pdo())
def test_a_mapping_that_begins_with_another_byte_holds_no_field(encoders):
    objects = position_objects(encoders)
    entries = [Entry(0x0005, 0, 8), *(alternatives[0] for alternatives in plan(encoders, objects))]
    assert not holds(entries, encoders, objects)


@given(encoders_of_one_pdo())
def test_each_channel_has_an_object_of_its_own(encoders):
    objects = position_objects(encoders)
    assert len(set(objects.values())) == len(encoders)


@given(st.integers(1, 63).filter(lambda bit: bit % 8))
def test_a_gap_that_is_no_whole_byte_is_refused_with_the_node(start):
    wheel = Encoder("a.left", 5, 0x185, start, 1, signed=False, sign=1, counts_per_turn=100.0)
    with pytest.raises(MappingImpossible) as caught:
        plan([wheel], position_objects([wheel]))
    assert caught.value.node == 5
