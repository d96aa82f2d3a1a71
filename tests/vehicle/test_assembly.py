"""Frames to samples: which frame answers a SYNC, gaps with their reasons, and travel lost in a restart."""

import itertools

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from omnimate.vehicle.assembly import (
    ACCEPTED,
    DUPLICATE,
    HELD,
    LATE,
    LATENCY_TOLERANCE,
    MAX_PDOS,
    REASONS,
    REPEATED,
    WRONG_LENGTH,
    SampleOpener,
    assembly_records,
    close_sample,
    open_sample,
    pdo_lengths,
    take_boot,
    take_frame,
    take_start,
)
from omnimate.vehicle.parameters import Bus, Encoder, Truck, VehicleParameters
from omnimate.vehicle.recording import Gap

PERIOD, BEGIN = 1 / 64, 2.0  # [s] between SYNCs and of the first; binary, so that sums are exact
ROUNDING = 4  # counts: of both wheels, at both ends of the gap
OPPOSITE = ({"sign": 1, "counts_per_turn": 40_000.0}, {"sign": -1, "counts_per_turn": 20_000.0})


def robot(**field):
    """A truck with two wheels, each in its own PDO."""
    field = {"start_bit": 0, "bits": 32, "signed": True} | field
    encoders = tuple(
        Encoder(channel, node, 0x180 + node, **field, **scale)
        for channel, node, scale in zip(("a.left", "a.right"), (1, 2), OPPOSITE, strict=True)
    )
    return VehicleParameters("r", {"a": Truck(0.3, 0.15, 0.15)}, None, Bus(500_000, PERIOD), encoders)


class Steps:
    """The steps, one SYNC after the other; times of gaps are since the first SYNC."""

    def __init__(self, vehicle=None):
        self.vehicle = vehicle or robot()
        self.state = self.cycle, self.pdos, self.channels = assembly_records(self.vehicle)
        self.number, self.gaps = 0, []

    def sync(self):
        open_sample(*self.state, BEGIN + self.number * PERIOD)
        self.number += 1

    def frame(self, place, count, latency=0.001, size=4):
        word = np.uint64(count % 2**64) & np.uint64(0xFFFFFFFF if size == 4 else 2**64 - 1)
        now = BEGIN + (self.number - 1) * PERIOD + latency
        return take_frame(self.cycle, self.pdos, place, word, size, now, now)

    def close(self):
        close_sample(*self.state)
        for column, (reason, start) in enumerate(self.channels[["ended_gap", "gap_start"]].tolist()):
            if reason:
                end = float(self.cycle["time"][0]) - BEGIN
                self.gaps.append(Gap(self.vehicle.channels[column], start - BEGIN, end, REASONS[reason]))
        return self.channels["count"].tolist(), self.channels["present"].tolist()

    def sample(self, *counts):
        """Take a sample in which each PDO answers, but those with None."""
        self.sync()
        for place, count in enumerate(counts):
            if count is not None:
                self.frame(place, count)
        return self.close()


def answers(*latencies):
    """Return the number of the frame that entered each sample, or None, from the times of its frames."""
    bus, entered = Steps(), []
    for times in latencies:
        bus.sync()
        for number, latency in enumerate(times):
            bus.frame(0, number, latency)
        bus.close()
        entered.append(int(bus.pdos["word"][0]) if bus.pdos["answered"][0] else None)
    return entered


@given(silent=st.integers(2, 60), begun=st.integers(1, 60), latency=st.floats(0.005, 0.015))
def test_a_burst_of_late_answers_never_counts_as_current(silent, begun, latency):
    """The first frames of it come late in one sample, the others in the next, before its own answer."""
    begun = min(begun, silent)
    late = [0.0001] * (silent - begun + 1)
    places = answers([0.001], *[[]] * silent, [latency] * begun, [*late, 0.001], [0.001])
    assert places[silent + 1 :] == [None, silent - begun + 1, 0]


@given(lost=st.integers(1, 60), later=st.booleans())
@example(lost=1, later=True)
@example(lost=2, later=True)
def test_answers_that_were_lost_are_not_waited_for(lost, later):
    """A node that answers again as before counts at once, and one that answers later at the second time."""
    times = [0.006 if later else 0.001]
    waited = later and lost > 1
    assert answers([0.001], *[[]] * lost, times, times)[-2:] == [None if waited else 0, 0]


@pytest.mark.parametrize(("excess", "entered"), [(0.0, 0), (2**-10, None)])
def test_a_sole_answer_after_missed_ones_may_come_later_than_before_by_the_tolerance(excess, entered):
    """Its latency counts from its own SYNC, in every sample."""
    before = PERIOD / 8
    later = before + LATENCY_TOLERANCE * PERIOD + excess
    assert answers([before], [before], [], [], [later])[-1] == entered


@pytest.mark.parametrize(
    ("samples", "tally"),
    [
        ([[0.001], [0.001]], (2, 0, 0, 0)),
        ([[0.001], []], (1, 1, 0, 0)),
        ([[0.001, 0.002]], (1, 0, 0, 1)),
        ([[0.001], [], [], [0.009]], (1, 2, 1, 0)),
        ([[0.001], [], [], [], [0.009, 0.01]], (1, 2, 2, 0)),
        ([[0.001], [], [], [0.009], [0.0001, 0.0002, 0.001]], (2, 0, 3, 0)),
    ],
)
def test_every_sync_is_answered_in_time_or_late_or_missing(samples, tally):
    """A late answer is taken off the missing ones; a further one to the same SYNC is a duplicate."""
    bus = Steps()
    for latencies in samples:
        bus.sync()
        for latency in latencies:
            bus.frame(0, 0, latency)
        bus.close()
    assert bus.pdos[["received", "missing", "late", "duplicate"]][0].tolist() == tally


def test_an_answer_after_its_sample_was_closed_is_not_waited_for_in_the_next():
    bus = Steps()
    bus.sample(0, 0)
    bus.sample(None, 0)
    assert bus.frame(0, 1, 0.014) == LATE
    bus.sync()
    assert bus.frame(0, 2, 0.009) == ACCEPTED
    assert bus.pdos[["missing", "late"]][0].tolist() == (0, 1)


def test_one_of_two_owed_answers_after_the_close_leaves_the_other_owed():
    bus = Steps()
    bus.sample(0, 0)
    bus.sample(None, 0)
    bus.sample(None, 0)
    assert bus.frame(0, 1, 0.014) == LATE
    bus.sync()
    assert (bus.frame(0, 2), bus.frame(0, 3)) == (HELD, ACCEPTED)


def test_a_further_answer_after_the_close_makes_up_for_no_missing_one():
    bus = Steps()
    bus.sample(0, 0)
    bus.sample(None, 0)
    assert (bus.frame(0, 1, 0.014), bus.frame(0, 1, 0.015)) == (LATE, LATE)
    assert bus.pdos[["missing", "late"]][0].tolist() == (0, 2)
    bus.sample(None, 0)
    bus.sync()
    assert bus.frame(0, 2) == HELD


def test_an_answer_of_a_wrong_length_is_neither_missing_nor_owed():
    bus = Steps()
    bus.sample(0, 0)
    bus.sync()
    assert bus.frame(0, 1, size=3) == WRONG_LENGTH
    assert bus.close()[1] == [False, False]
    bus.sync()
    assert bus.frame(0, 2, 0.009) == ACCEPTED
    assert bus.pdos[["missing", "wrong_length"]][0].tolist() == (0, 1)


@pytest.mark.parametrize(
    ("is_timed", "further"), [(False, (DUPLICATE, DUPLICATE)), (True, (REPEATED, REPEATED))]
)
def test_the_first_frame_of_a_timed_pdo_is_taken_and_the_others_are_no_errors(is_timed, further):
    bus = Steps()
    bus.pdos["is_timed"] = is_timed
    bus.sync()
    assert bus.frame(0, 1) == ACCEPTED
    fates = [bus.frame(0, 2)]
    bus.close()
    assert (*fates, bus.frame(0, 3)) == further
    assert bus.pdos[["word", "late", "duplicate"]][0].tolist() == (1, 0, 0 if is_timed else 2)


def test_the_first_frame_is_held_while_an_answer_is_owed_and_the_second_taken():
    bus = Steps()
    bus.sample(None, 0)
    bus.sync()
    assert (bus.frame(0, 1), bus.frame(0, 2)) == (HELD, ACCEPTED)


@pytest.mark.parametrize(("before", "is_doubted"), [(0, False), (1, True), (4, True)])
def test_a_boot_up_is_doubted_where_answers_go_on(before, is_doubted):
    """The first answer of all confirms it."""
    bus = Steps()
    for number in range(before):
        bus.sample(number, 0)
    take_boot(bus.pdos, 1)
    bus.sample(before, 0)
    assert bus.pdos["is_boot_doubted"].tolist() == [is_doubted, False]


@pytest.mark.parametrize(
    ("started", "confirmed"), [(0, [True, True]), (1, [True, False]), (2, [False, True])]
)
def test_a_start_of_a_node_or_of_all_confirms_a_boot_up(started, confirmed):
    bus = Steps()
    bus.sample(0, 0)
    for node in (1, 2):
        take_boot(bus.pdos, node)
    take_start(bus.pdos, started)
    bus.sample(1, 1)
    assert bus.pdos["has_restarted"].tolist() == confirmed


@pytest.mark.parametrize("skipped", [-1, 0, 1, 7])
@pytest.mark.parametrize("excess", [0, 1])
def test_a_counter_may_move_by_its_largest_step_in_every_sync_period(skipped, excess):
    """Also where no sample was opened for some; two SYNCs at once count as one period."""
    bus = Steps()
    for _ in range(3):
        bus.sample(0, 0)
    bus.number += skipped
    count = int(bus.channels["max_step"][0]) * (max(skipped, 0) + 1) + excess
    assert bus.sample(count, 0)[1] == [excess == 0, True]


@pytest.mark.parametrize(("start", "bits", "length"), [(0, 1, 1), (0, 32, 4), (0, 33, 5), (7, 57, 8)])
def test_a_pdo_needs_the_bytes_up_to_the_last_bit_of_its_fields(start, bits, length):
    assert pdo_lengths(robot(start_bit=start, bits=bits)) == {0x181: length, 0x182: length}


@given(
    start=st.integers(0, 63), bits=st.integers(1, 64), signed=st.booleans(), word=st.integers(0, 2**64 - 1)
)
def test_a_field_is_decoded_as_its_bits_say(start, bits, signed, word):
    bits = min(bits, 64 - start)
    bus = Steps(robot(start_bit=start, bits=bits, signed=signed))
    raw = (word >> start) & (2**bits - 1)
    expected = raw - 2**bits if signed and raw >> (bits - 1) else raw
    bus.sync()
    bus.frame(0, word, size=8)
    assert (bus.close()[0][0] - expected) % 2**64 == 0


@pytest.mark.parametrize(
    ("counts", "gaps"),
    [
        ([0, 1, 2], []),
        ([0, 1, None, None, 4, 5], [(1, 4, "missing")]),
        ([0, 2**30, 2, 3], [(0, 2, "jump")]),
        ([None, 1, None, 3], [(0, 1, "missing"), (1, 3, "missing")]),
        ([0, "restarted", 2], [(0, 1, "reboot")]),
        ([0, None, None, "restarted", 4], [(0, 3, "reboot")]),
        ([0, "restarted", 2, None, 4], [(0, 1, "reboot"), (2, 4, "missing")]),
    ],
)
def test_a_gap_reaches_from_the_last_good_sample_to_the_next_and_has_its_reason(counts, gaps):
    bus = Steps()
    for number, count in enumerate(counts):
        if count == "restarted":
            take_boot(bus.pdos, 1)
            take_start(bus.pdos, 1)
        bus.sample(number if count == "restarted" else count, 0)
    ended = [(round(gap.start / PERIOD), round(gap.end / PERIOD), gap.reason) for gap in bus.gaps]
    assert ended == gaps


@given(st.lists(st.tuples(st.booleans(), st.booleans()), min_size=1, max_size=30))
def test_a_channel_is_absent_exactly_within_its_gaps(presence):
    bus = Steps()
    for row in [*presence, (True, True)]:
        bus.sample(*(0 if present else None for present in row))
    for column, channel in enumerate(("a.left", "a.right")):
        gaps = [gap for gap in bus.gaps if gap.channel == channel]
        for index, row in enumerate(presence):
            time = index * PERIOD
            assert row[column] or any(gap.start <= time <= gap.end for gap in gaps)
            assert not row[column] or not any(gap.start < time < gap.end for gap in gaps)
        assert all(before.end <= after.start for before, after in itertools.pairwise(gaps))


def drive(truth, column, missing, restart):
    """Return the counts of a drive in which a counter is not read for some samples and then restarts."""
    bus, rows = Steps(), []
    for number, row in enumerate(truth.tolist()):
        raw = [*row]
        for lost in column:
            raw[lost] = row[lost] - int(truth[restart, lost]) if number >= restart else raw[lost]
            if number == restart:
                take_boot(bus.pdos, lost + 1)
                take_start(bus.pdos, lost + 1)
            if number in missing:
                raw[lost] = None
        rows.append(bus.sample(*raw)[0])
    return np.array(rows)


@given(st.integers(-400, 400), st.floats(-3, 3), st.integers(0, 1), st.integers(1, 40))
def test_driving_at_a_constant_proportion_loses_nothing(speed, ratio, column, gap):
    """A straight, an arc or a turn on the spot: the restarted wheel ends within a count of the truth."""
    steps = np.arange(120)
    truth = np.stack([steps * speed, np.round(-steps * speed * ratio / 2)], axis=1).astype(np.int64)
    found = drive(truth, [column], range(50, 50 + gap), 50 + gap)
    still = abs(truth[1, 1 - column]) * (2, 1)[column] * 4 < abs(truth[1, column]) * (1, 2)[column]
    lost = abs(int(truth[50 + gap, column] - truth[49, column]))
    error = np.abs(found[-1, column] - truth[-1, column])
    assert error <= lost + ROUNDING, "never worse than what the lost samples explain"
    if not still and abs(truth[1, 1 - column]) > 25:
        assert error <= 0.01 * lost + ROUNDING, "rounding of the proportion only"


def test_a_standing_robot_loses_nothing_and_both_wheels_at_once_stay_where_they_were():
    standing = np.tile([5000, -900], (30, 1))
    assert drive(standing, [0], (), 20).tolist() == standing.tolist()
    moving = np.stack([np.arange(30) * 10, -np.arange(30) * 5], axis=1)
    assert drive(moving, [0, 1], (), 20)[20].tolist() == moving[19].tolist()


def test_a_pdo_opens_the_samples_from_its_next_frame_on_after_ten_in_one_sample():
    """The one before it does not do so any more; each PDO counts for itself, from the start of a sample."""
    opener = SampleOpener(0x181, (0x181, 0x182, 0x183))
    for _ in range(3):
        assert opener.opens(0x181)
        assert not any(opener.opens(cob_id) for cob_id in [0x182, 0x183] * MAX_PDOS)
    assert MAX_PDOS == 10
    assert opener.opens(0x183)
    assert not any(opener.opens(cob_id) for cob_id in [0x181, 0x182] * MAX_PDOS)
    assert opener.opens(0x183)
    assert not opener.opens(0x182)


@pytest.mark.parametrize(("identifier", "pdos"), [(0x080, ()), (0x181, (0x181, 0x182))])
def test_no_frame_but_the_vehicles_pdos_takes_the_place_of_the_one_that_opens_samples(identifier, pdos):
    """Nothing takes the place of SYNC."""
    opener = SampleOpener(identifier, pdos)
    assert not any(opener.opens(other) for other in [0x183] * 100)
    assert opener.opens(identifier)
