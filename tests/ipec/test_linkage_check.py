"""Linkage channels that cannot be believed are named, with what to do; those that can are not."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.ipec.corrector import Corrector, correct
from omnimate.ipec.errors import LinkageChannelError, NoLinkageError
from omnimate.ipec.filter.estimate import estimate
from omnimate.ipec.filter.live import Filter
from omnimate.ipec.filter.smoother import smooth
from omnimate.ipec.linkage_check import LINKAGE, check_linkage, frozen_channels
from omnimate.ipec.readings import ordered_counts, scales_of
from omnimate.ipec.tracker import Tracker, track_recording
from omnimate.motion.paths import free, out_and_back, squares
from omnimate.vcan_sim.floor import Floor, bumps_under
from omnimate.vcan_sim.reference import reference_single
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.recording import Recording
from tests.recordings import frozen

PROGRAMS = [free(1, 1), squares(["cw"], 2.0, link_length=1.0), out_and_back(18.0, 1, link_length=1.0)]


def bumpy(robot, program):
    bumps = bumps_under("a.right", 10, 1.0, 15.0)
    return simulate(robot, Truth(robot, floor=Floor(bumps=bumps), seed=2), program)


@pytest.mark.parametrize("program", PROGRAMS, ids=["free", "squares", "straight"])
def test_a_sound_linkage_passes_even_on_a_bumpy_floor(coarse, program):
    recording = bumpy(coarse, program)
    assert frozen_channels(recording) == ()
    check_linkage(recording)


@pytest.mark.parametrize("channel", ["joint_a", "joint_b"])
@pytest.mark.parametrize("program", PROGRAMS[:2], ids=["free", "squares"])
def test_a_frozen_joint_is_named_with_its_node_and_time(robot, channel, program):
    recording = bumpy(robot, program)
    first = len(recording) // 3
    recording = frozen(recording, channel, first)
    stretches = frozen_channels(recording)
    assert {stretch.channel for stretch in stretches} == {channel}
    assert stretches[0].start >= recording.time[first] - 5.0
    with pytest.raises(LinkageChannelError, match=rf"{channel} \(node .\) stands still .* check") as caught:
        check_linkage(recording)
    assert caught.value.channel == channel


def test_a_frozen_link_is_named(robot):
    """Truck b stands while a pulls the slider out by 120 mm."""
    count = 200
    counts = np.zeros((count, 7), np.int64)
    counts[:, 4:] = [encoder.zero for encoder in robot.encoders[4:]]
    counts[:, 0] = np.round(0.12 / robot.metres_per_count("a.left") * np.arange(count) / count)
    counts[:, 1] = np.round(0.12 / robot.metres_per_count("a.right") * np.arange(count) / count)
    recording = Recording(robot, 0.015 * np.arange(count), counts, np.ones(counts.shape, bool))
    with pytest.raises(LinkageChannelError, match=r"link \(node 7\) stands still .* 119 mm"):
        check_linkage(recording)


@pytest.mark.parametrize("channel", LINKAGE)
def test_a_channel_that_was_never_read_is_named(robot, channel):
    recording = bumpy(robot, PROGRAMS[1])
    present = recording.present.copy()
    present[:, robot.channels.index(channel)] = False
    recording = replace(recording, present=present)
    with pytest.raises(LinkageChannelError, match=rf"{channel} .* never read"):
        check_linkage(recording)


@pytest.mark.parametrize("method", [correct, estimate, smooth])
def test_every_method_refuses_a_frozen_channel(robot, method):
    recording = frozen(bumpy(robot, PROGRAMS[0]), "joint_a", 500)
    with pytest.raises(LinkageChannelError, match="joint_a"):
        method(recording)


def test_a_wheel_that_spins_once_is_no_frozen_joint(coarse):
    recording = bumpy(coarse, PROGRAMS[2])
    counts = recording.counts.copy()
    counts[1000:, 0] += round(0.05 / coarse.metres_per_count("a.left"))
    check_linkage(replace(recording, counts=counts))


@pytest.mark.parametrize(
    "method",
    [
        correct,
        estimate,
        smooth,
        check_linkage,
        ordered_counts,
        lambda recording: track_recording(recording, 0.1),
    ],
)
def test_a_recording_of_one_truck_is_refused(method):
    single = reference_single()
    recording = Recording(single, np.arange(2.0), np.zeros((2, 2), np.int64), np.ones((2, 2), bool))
    with pytest.raises(NoLinkageError, match=r"recording: .* single truck .*track_one_truck"):
        method(recording)


@pytest.mark.parametrize("make", [Corrector, Filter, Tracker, scales_of])
def test_a_live_robot_with_one_truck_is_refused(make):
    with pytest.raises(NoLinkageError, match="labmate"):
        make(reference_single())
