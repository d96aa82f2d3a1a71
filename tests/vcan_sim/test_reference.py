"""The reference vehicles have the numbers of the papers and of the specification's example."""

from omnimate.vcan_sim.reference import reference_single, reference_vehicle
from omnimate.vehicle.parameters import CHANNELS


def test_the_reference_vehicle_is_the_nominal_two_truck_robot():
    vehicle = reference_vehicle()
    assert vehicle.channels == CHANNELS
    assert [encoder.node for encoder in vehicle.encoders] == [1, 2, 3, 4, 5, 6, 7]
    assert [encoder.cob_id for encoder in vehicle.encoders] == list(range(0x181, 0x188))
    assert [drive.cob_id for drive in vehicle.drives] == [0x20B, 0x20C, 0x20D, 0x20E]
    assert (vehicle.bus.bitrate, vehicle.bus.sync_period) == (500_000, 0.015)
    assert vehicle.trucks["a"].wheelbase == 0.340
    assert vehicle.wheel_diameter("b.right") == 0.150
    assert vehicle.linkage.length == 1.000


def test_a_joint_cannot_wrap_within_half_a_turn_and_the_link_not_within_its_stroke():
    vehicle = reference_vehicle()
    joint, link = vehicle.encoder("joint_a"), vehicle.encoder("link")
    assert joint.zero == joint.wrap_range / 2
    assert link.zero * link.scale == 0.5


def test_the_single_truck_is_the_front_one_alone():
    vehicle = reference_single()
    assert vehicle.linkage is None
    assert vehicle.channels == ("a.left", "a.right")
    assert vehicle.trucks["a"] == reference_vehicle().trucks["a"]
