"""The expected PDOs of a vehicle carry every encoder at its place, each in one PDO."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from omnimate.driver.robot.events import NodeCounts, nodes_of
from omnimate.driver.robot.expected_pdos import expected_pdos, pdo_lengths

places = st.tuples(st.integers(0, 32), st.integers(1, 32), st.booleans())


@given(left=places, right=places, together=st.booleans(), counts=st.tuples(st.integers(), st.integers()))
def test_what_an_encoder_sends_is_what_is_decoded(kit, left, right, together, counts):
    (start, bits, signed), (_, right_bits, right_signed) = left, right
    if together:
        right_place = {"cob_id": 0x181, "start_bit": start + bits}
        right_bits = min(right_bits, 64 - start - bits)
        if not right_bits:
            return
    else:
        right_place = {"cob_id": 0x182, "start_bit": right[0]}
    vehicle = kit.one_truck(
        (
            kit.wheel_encoder("a.left", 1, start_bit=start, bits=bits, signed=signed),
            kit.wheel_encoder(
                "a.right", 1 if together else 2, bits=right_bits, signed=right_signed, **right_place
            ),
        )
    )
    pdos = expected_pdos(vehicle, {node: NodeCounts() for node in nodes_of(vehicle)})
    assert sorted(field.column for pdo in pdos.values() for field in pdo.fields) == [0, 1]
    for column, encoder in enumerate(vehicle.encoders):
        raw = counts[column] % 2**encoder.bits
        value = raw - 2**encoder.bits if encoder.signed and raw >> (encoder.bits - 1) else raw
        (field,) = [field for field in pdos[encoder.cob_id].fields if field.column == column]
        assert field.decode(raw << encoder.start_bit) == value
        assert 8 * pdos[encoder.cob_id].length >= encoder.start_bit + encoder.bits
    assert pdo_lengths(vehicle) == {cob_id: pdo.length for cob_id, pdo in pdos.items()}


def test_a_vehicle_has_the_nodes_of_its_encoders_and_drives(kit):
    vehicle = kit.one_truck(drives=(kit.drive("a.left", 18), kit.drive("a.right", 17)))
    assert nodes_of(vehicle) == (1, 2, 17, 18)
