"""The signals that effects act on run on, whatever the geometry does."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.files.importers.robots import single_truck
from omnimate.mismatch.recording.signals import MAX_SPEED_STEP, expected_reading, grid, signals_of
from omnimate.vehicle.parameters import Truck
from omnimate.vehicle.recording import Lap, Recording, Run


def test_readings_go_on_where_a_joint_goes_round(drive):
    """A jump by a whole turn would look like an effect to whatever shifts or smooths a reading."""
    recording = drive(laps=1)
    turn = int(recording.vehicle.encoder("joint_b").counts_per_turn)
    counts = recording.counts.copy()
    joint = recording.vehicle.channels.index("joint_b")
    counts[:, joint] += np.linspace(0.0, 1.5 * turn, len(counts)).astype(np.int64)
    reading = signals_of(replace(recording, counts=counts)).block.reading
    assert np.ptp(reading[:, 1]) > 2.0 * np.pi
    assert np.abs(np.diff(reading, axis=0)).max() < 0.05


def test_a_perfect_linkage_reads_what_the_trajectory_says_just_before_and_after(drive):
    signals = signals_of(drive(laps=1))
    expected = expected_reading(signals.path)
    turned = np.angle(np.exp(1j * (expected[2:, :2] - expected[:-2, :2])))
    off = np.exp(1j * signals.block.reading[:-1, :2]) - np.exp(1j * (expected[:-2, :2] + 0.5 * turned))
    assert np.abs(off).max() < 1e-9


def test_signals_do_not_depend_on_the_order_of_the_encoders_in_the_file(drive):
    recording = drive(laps=1)
    vehicle = replace(recording.vehicle, encoders=recording.vehicle.encoders[::-1])
    turned = replace(
        recording, vehicle=vehicle, counts=recording.counts[:, ::-1], present=recording.present[:, ::-1]
    )
    one, other = signals_of(recording), signals_of(turned)
    assert one.resolution.tolist() == other.resolution.tolist()
    assert np.array_equal(one.path, other.path)


def test_frames_that_are_missing_do_not_make_a_wheel_stand_still(drive):
    recording = drive(laps=1)
    channel = recording.vehicle.channels.index("a.left")
    counts, present = recording.counts.copy(), recording.present.copy()
    for at in range(500, 2500, 40):
        counts[at : at + 3, channel] = counts[at - 1, channel]
        present[at : at + 3, channel] = False
    lost = signals_of(replace(recording, counts=counts, present=present))
    whole = signals_of(recording)
    assert np.abs(lost.block.travel - whole.block.travel).max() < 3e-4
    assert lost.block.travel[:, 0].sum() == pytest.approx(whole.block.travel[:, 0].sum())


def test_windows_are_even_and_hold_the_first_and_the_last_sample(drive):
    time = drive(laps=1).time
    ends = grid(time)
    assert (ends[0], ends[-1]) == (0, len(time) - 1)
    assert np.ptp(np.diff(ends)) <= 1


@pytest.mark.parametrize("counts_per_turn", [300.0, 500.0])
def test_in_speeds_on_which_a_law_is_learned_no_count_of_a_coarse_encoder_shows(counts_per_turn):
    """On a circle at a constant pace; ten readings a second."""
    time = 0.1 * np.arange(600)
    robot = single_truck("coarse", Truck(0.27, 0.044, 0.044), counts_per_turn, 0.1)
    count = abs(robot.metres_per_count("a.left"))
    counts = np.rint(np.outer(time, [0.32, 0.38]) / count).astype(np.int64)
    run = Run("free", None, (Lap("none", time[0], time[-1]),))
    signals = signals_of(Recording(robot, time, counts, np.ones(counts.shape, bool), None, run))
    within = slice(10, -10)
    assert np.abs(signals.block.speed[within] - [0.32, 0.38]).max() > MAX_SPEED_STEP
    assert np.abs(signals.smooth_block.speed[within] - [0.32, 0.38]).max() < MAX_SPEED_STEP
