import math
import operator

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from omnimate.driver.robot.assembler import Assembler
from omnimate.files.logs.assemble import assemble
from omnimate.files.logs.frames import Frame, frames_of
from tests.driver.conftest import two_trucks

VEHICLE = two_trucks(0.015, signed=True)
COB_IDS = [encoder.cob_id for encoder in VEHICLE.encoders]


@pytest.fixture
def assembler():
    return Assembler(VEHICLE)


def answer(assembler, count, cob_ids=COB_IDS):
    for cob_id in cob_ids:
        assembler.frame(cob_id, count.to_bytes(4, "little", signed=True), 1.0, 2.0)


def cycle(assembler, index, count, cob_ids=COB_IDS):
    assembler.begin(index, 0.015 * index)
    answer(assembler, count, cob_ids)
    return assembler.close()


def test_all_answers_make_a_full_sample(assembler):
    sample = cycle(assembler, 0, 5)
    assert sample.counts == (5,) * 7
    assert sample.present == (True,) * 7
    assert sample.device_time == (1.0,) * 7
    assert sample.arrival_time == (2.0,) * 7
    assert assembler.is_complete


def test_a_missing_answer_is_counted_and_repeats_the_last_count(assembler):
    cycle(assembler, 0, 5)
    sample = cycle(assembler, 1, 6, COB_IDS[1:])
    assert sample.counts == (5, 6, 6, 6, 6, 6, 6)
    assert sample.present == (False, *[True] * 6)
    assert math.isnan(sample.device_time[0])
    assert math.isnan(sample.arrival_time[0])
    assert assembler.counts[1].missing == 1


def test_a_frame_after_the_sample_closed_is_late(assembler):
    cycle(assembler, 0, 5)
    cycle(assembler, 1, 6, COB_IDS[1:])
    answer(assembler, 6, COB_IDS[:1])
    sample = cycle(assembler, 2, 7)
    assert sample.counts == (7,) * 7
    assert sample.present == (True,) * 7
    assert (assembler.counts[1].late, assembler.counts[1].missing) == (1, 0)


def test_a_late_answer_after_the_next_sync_never_enters_its_sample(assembler):
    cycle(assembler, 0, 5)
    cycle(assembler, 1, 6, COB_IDS[1:])
    assembler.begin(2, 0.03)
    answer(assembler, 6, COB_IDS[:1])
    assert not assembler.is_settled
    answer(assembler, 7)
    assert assembler.is_settled
    sample = assembler.close()
    assert sample.counts == (7,) * 7
    assert (assembler.counts[1].late, assembler.counts[1].missing) == (1, 0)


def test_the_first_of_two_answers_counts(assembler):
    assembler.begin(0, 0.0)
    answer(assembler, 5)
    answer(assembler, 6, COB_IDS[:1])
    assert assembler.close().counts == (5,) * 7
    assert assembler.counts[1].duplicate == 1


@pytest.mark.parametrize("data", [b"", b"\x01", b"\x01\x02\x03"])
def test_a_short_pdo_never_enters_a_sample(assembler, data):
    assembler.begin(0, 0.0)
    assembler.frame(COB_IDS[0], data, 0.0, 0.0)
    answer(assembler, 5, COB_IDS[1:])
    assert not assembler.close().present[0]
    assert assembler.counts[1].wrong_length == 1


def takes(assembler, index, data):
    """Say whether a sample takes the data of the first PDO."""
    assembler.begin(index, 0.015 * index)
    assembler.frame(COB_IDS[0], data, 0.0, 0.0)
    return bool(assembler.close().present[0])


def test_a_long_pdo_is_taken_until_the_first_of_the_length_of_its_mapping(assembler):
    assert takes(assembler, 0, b"\x05\0\0\0\xff")
    assert not assembler.events.all()
    assembler.expect_length(COB_IDS[0], 4)
    assert takes(assembler, 1, b"\x06\0\0\0\xff\0\0\0")
    assert [event.what for event in assembler.events.all()] == [
        "PDO 181h has 8 bytes and its mapping 4: the first are taken"
    ]
    assert takes(assembler, 2, b"\x07\0\0\0")
    assert not takes(assembler, 3, b"\x08\0\0\0\xff\0\0\0")
    assert not takes(assembler, 4, b"\x09\0\0")


def test_a_silent_node_is_not_waited_for_until_it_is_heard(assembler):
    for index in range(3):
        cycle(assembler, index, 5, COB_IDS[1:])
    assembler.begin(3, 0.045)
    answer(assembler, 5, COB_IDS[1:])
    assert assembler.is_complete
    assert assembler.is_settled
    answer(assembler, 5, COB_IDS[:1])
    assembler.close()
    assembler.begin(4, 0.06)
    answer(assembler, 5, COB_IDS[1:])
    assert not assembler.is_settled
    words = [event.what for event in assembler.events.all()]
    assert words == [
        "a.left: no valid answer to SYNC",
        "a.left: answers SYNC again after 3 without",
    ]


def test_after_a_silence_of_all_nodes_their_first_answers_are_waited_for_shortly(assembler):
    """A sample that is closed at its SYNC would make late frames of answers that are in time."""
    for index in range(4):
        cycle(assembler, index, 5, [])
    assembler.begin(4, 0.06)
    assert assembler.is_complete
    assert not assembler.is_settled
    answer(assembler, 5)
    assert all(assembler.close().present)


def test_a_silent_node_of_which_a_late_frame_comes_is_waited_for_again(assembler):
    cycle(assembler, 0, 5)
    for index in range(1, 5):
        cycle(assembler, index, 5, COB_IDS[1:])
    assembler.begin(5, 0.075)
    answer(assembler, 5, COB_IDS[1:])
    assert assembler.is_settled
    assembler.frame(COB_IDS[0], bytes(4), 0.0, 4.0)
    assert not assembler.close().present[0], "later than before, it may be the answer to an earlier SYNC"
    assembler.begin(6, 0.09)
    answer(assembler, 5, COB_IDS[1:])
    assert not assembler.is_settled


def test_a_node_that_missed_a_sync_is_only_hoped_for_until_it_is_trusted_again(assembler):
    """Each wait for a node that often misses would cost the whole window."""
    cycle(assembler, 0, 5, COB_IDS[1:])
    for index in range(1, 101):
        assembler.begin(index, 0.015 * index)
        answer(assembler, 5, COB_IDS[1:])
        assert assembler.is_complete
        assert not assembler.is_settled
        answer(assembler, 5, COB_IDS[:1])
        assert assembler.is_settled or index == 1
        assembler.close()
    assembler.begin(101, 1.515)
    answer(assembler, 5, COB_IDS[1:])
    assert not assembler.is_complete


def test_a_restart_rebases_wheels_and_not_joints(assembler):
    cycle(assembler, 0, 1000)
    cycle(assembler, 1, 1010)
    for node in (1, 5):
        assembler.node_booted(node)
        assembler.node_started(node)
    sample = cycle(assembler, 2, 1020)
    assert sample.counts[0] == 1020, "the other wheel drove on by ten counts, in proportion"
    assert sample.counts[1] == 1020
    assert sample.counts[4] == 1020
    assert [(gap.channel, gap.reason) for gap in assembler.gaps] == [
        ("a.left", "reboot"),
        ("joint_a", "reboot"),
    ]


def test_an_impossible_reading_is_a_jump(assembler):
    cycle(assembler, 0, 0)
    sample = cycle(assembler, 1, 2**30)
    assert sample.present == (False,) * 7
    assert assembler.counts[1].jumps == 1
    assert {gap.reason for gap in assembler.gaps_until_now()} == {"jump"}


def test_syncs_that_were_left_out_widen_what_a_counter_may_have_moved(assembler):
    cycle(assembler, 0, 0)
    assert cycle(assembler, 1001, 200_000).present[0]


def test_a_boot_up_is_believed_where_the_pdos_stopped_and_not_where_they_go_on(assembler):
    cycle(assembler, 0, 1000)
    assembler.node_booted(1)
    assert cycle(assembler, 1, 1010).counts[0] == 1010
    assert [event.what for event in assembler.events.all()] == [
        "its boot-up is not believed: its PDOs did not stop"
    ]
    assembler.node_booted(1)
    cycle(assembler, 2, 1020, COB_IDS[1:])
    assert cycle(assembler, 3, 1030).present[0]
    assert [(gap.channel, gap.reason) for gap in assembler.gaps] == [("a.left", "reboot")]


frames = st.tuples(st.sampled_from([0, 1, 2, 3, 4, 5, 6]), st.binary(max_size=8), st.booleans())
cycles = st.lists(st.lists(frames, max_size=20), min_size=1, max_size=20)


@given(cycles)
def test_no_order_loss_or_length_raises_or_mixes_cycles(script):
    """Whatever comes, a sample shows only values that came after its own SYNC."""
    assembler = Assembler(VEHICLE)
    for column in range(7):
        assembler.expect_length(COB_IDS[column], 8)
    for index, arriving in enumerate(script):
        assembler.begin(index, 0.015 * index)
        arrived = set()
        for number, (column, data, is_good) in enumerate(arriving):
            stamp = 1000.0 * index + number
            payload = index.to_bytes(4, "little") + bytes(4) if is_good else data
            assembler.frame(COB_IDS[column], payload, stamp, stamp)
            if len(payload) == 8:
                arrived.add((column, stamp))
        sample = assembler.close()
        for column in range(7):
            if sample.present[column]:
                assert (column, sample.device_time[column]) in arrived
            else:
                assert math.isnan(sample.device_time[column])
    for counts in assembler.counts.values():
        assert min(counts.received, counts.missing, counts.late, counts.duplicate, counts.wrong_length) >= 0


stretches = st.sampled_from([["good"], ["lost"], ["double"], ["late", "good"], ["lost", "late", "double"]])


@given(st.lists(stretches, min_size=1, max_size=40))
def test_a_value_in_a_sample_is_the_answer_to_its_own_sync(stretches):
    """Answers that get lost, come twice, or come after the next SYNC and before its answer."""
    assembler = Assembler(VEHICLE)
    owed = None
    for index, fate in enumerate(fate for stretch in stretches for fate in stretch):
        assembler.begin(index, 0.015 * index)
        if owed is not None:
            answer(assembler, owed, COB_IDS[:1])
        owed = index if fate == "late" else None
        for _ in range({"good": 1, "double": 2}.get(fate, 0)):
            answer(assembler, index, COB_IDS[:1])
        sample = assembler.close()
        is_good = fate in {"good", "double"}
        assert not sample.present[0] or (is_good and sample.counts[0] == index)


seen = st.one_of(
    st.tuples(st.just("sync"), st.just(0), st.just(0)),
    st.tuples(st.sampled_from(["pdo", "short"]), st.integers(0, 6), st.integers(-900, 900)),
    st.tuples(st.sampled_from(["boot", "start"]), st.integers(1, 7), st.just(0)),
)


@given(st.lists(seen, max_size=120))
@example([("pdo", 0, 900), ("sync", 0, 0), ("boot", 1, 0), ("start", 1, 0), ("pdo", 0, 0)])
def test_a_log_of_what_was_seen_live_gives_the_same_samples(events):
    """Both run the same steps; this is about how each finds them in its frames."""
    assembler, samples, frames = Assembler(VEHICLE), [], []
    for number, (what, which, count) in enumerate([("sync", 0, 0), *events]):
        time = 0.004 * number
        data = count.to_bytes(4, "little", signed=True)[: 3 if what == "short" else 4]
        if what == "sync":
            if assembler.is_open:
                samples.append(assembler.close())
            assembler.begin(len(samples), time)
            frames.append(Frame(time, 0x080))
        elif what == "boot":
            assembler.node_booted(which)
            frames.append(Frame(time, 0x700 + which, b"\0"))
        elif what == "start":
            assembler.node_started(which)
            frames.append(Frame(time, 0x000, bytes([1, which])))
        else:
            assembler.frame(COB_IDS[which], data, time, time)
            frames.append(Frame(time, COB_IDS[which], data))
    samples.append(assembler.close())
    assembly = assemble(frames_of(frames), VEHICLE)
    assert assembly.recording.present.tolist() == [list(sample.present) for sample in samples]
    for index, sample in enumerate(samples):
        shown = [assembly.recording.present[: index + 1, column].any() for column in range(7)]
        counts = assembly.recording.counts[index].tolist()
        assert all(a == b for a, b, there in zip(counts, sample.counts, shown, strict=True) if there)
    key = operator.attrgetter("start", "channel")
    assert list(assembly.recording.gaps) == sorted(assembler.gaps_until_now(), key=key)
    for pdo in assembly.pdos:
        counted = assembler.counts[pdo.node]
        assert (pdo.used, pdo.late, pdo.missing) == (counted.received, counted.late, counted.missing)
