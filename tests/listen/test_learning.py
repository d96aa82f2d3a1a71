"""A whole bus: nodes, when PDOs are sent, signals, wheels; and the files that are written."""

import itertools
import json

import cantools
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.files.logs.frames import EXTENDED, REMOTE, Frame, frames_of
from omnimate.files.logs.signals import Signal
from omnimate.listen.dbc import learned_dbc
from omnimate.listen.draft import draft_vehicle
from omnimate.listen.learning import learn_bus
from omnimate.listen.meanings import meanings_of
from omnimate.listen.report import WIDTH, findings_as_json, report_lines
from tests.listen.conftest import PERIOD, in_order, robot_log


def message_of(findings, can_id):
    return next(each for each in findings.messages if each.message.can_id == can_id)


def test_nodes_states_and_sync_are_those_of_the_log(robot_findings):
    network = robot_findings.network
    assert set(network.nodes) == {5, 6}
    assert network.nodes[5].states == ("operational",)
    assert network.nodes[5].heartbeat == pytest.approx(1.0)
    assert network.sync_period == pytest.approx(PERIOD)


def test_services_are_reported_in_words():
    extra = [
        Frame(0.1, 0x705, b"\0"),
        Frame(0.2, 0x000, b"\x01\x00"),
        Frame(1.0, 0x085, bytes.fromhex("1081010000000000")),
        Frame(2.0, 0x605, bytes.fromhex("4000100000000000")),
        Frame(2.1, 0x585, bytes.fromhex("4300100096010200")),
        Frame(3.0, 0x100, bytes(6)),
    ]
    network = learn_bus(robot_log(extra=extra)).network
    assert network.commands == {"start, all nodes": 1}
    assert network.nodes[5].states == ("boot-up", "operational")
    assert network.nodes[5].emergencies == {"8110h CAN overrun, objects lost": 1}
    assert network.nodes[5].profile == 406
    assert network.time_stamps == 1


def test_a_pdo_after_each_sync_and_another_after_each_fifth_are_identified(robot_findings):
    sending = message_of(robot_findings, 0x185).sending
    assert (sending.cause, sending.every) == ("SYNC", 1)
    assert message_of(robot_findings, 0x286).sending.every == 5


def test_a_timer_and_a_device_that_sends_changes_are_distinguished():
    random = np.random.default_rng(0)
    time = np.arange(0, 40, 0.05) + random.normal(0, 0.0002, 800)
    value = np.floor(np.where(np.arange(800) % 200 < 100, np.arange(800) * 3, 0)).astype(int)
    rows = [Frame(t, 0x185, int(v).to_bytes(4, "little")) for t, v in zip(time, value, strict=True)]
    changes = [rows[0], *(b for a, b in itertools.pairwise(rows) if a.data != b.data)]
    beats = [Frame(t + 0.1, 0x705, b"\x05") for t in range(40)]
    for frames, cause in ((rows, "timer"), (changes, "change")):
        log = in_order([*frames, *beats])
        assert message_of(learn_bus(log), 0x185).sending.cause == cause


def test_position_speed_status_and_temperature_have_their_fields(robot_findings):
    fields = [(s.start, s.bits, s.kind) for s in message_of(robot_findings, 0x185).signals]
    assert fields == [(0, 32, "number"), (32, 16, "number")]
    fields = [(s.start, s.bits, s.kind) for s in message_of(robot_findings, 0x286).signals]
    assert fields == [(0, 16, "status word"), (16, 16, "number")]


def test_the_sign_of_a_counter_that_passes_zero_stays_open_and_that_of_a_speed_is_identified(robot_findings):
    position, speed = message_of(robot_findings, 0x185).signals
    assert (position.signed, speed.signed) == (None, True)


def test_wheels_their_direction_ratio_and_speeds_are_found(robot_findings):
    wheels = robot_findings.kinematics.wheels
    assert [wheel.shaft.position.signal.can_id for wheel in wheels] == [0x185, 0x186]
    assert [wheel.forward for wheel in wheels] == [-1, 1]
    assert wheels[1].ratio == pytest.approx(-1.0, abs=0.01)
    rates = {signal.can_id: factor for wheel in wheels for signal, factor, _ in wheel.shaft.rates}
    assert rates[0x185] == pytest.approx(100 * 2 * np.pi / 20000, rel=0.02)


def test_a_turn_of_known_direction_identifies_left_and_right(robot_findings):
    assert robot_findings.kinematics.turn_starts[0] - robot_findings.start == pytest.approx(12.0, abs=0.5)
    text = draft_vehicle(robot_findings, 250000, "left")
    first, second = text.split("[[encoder]]")[1:]
    assert '\nchannel = "a.left"' in first
    assert "cob_id = 0x185" in first
    assert "\nsign = -1" in first
    assert '\nchannel = "a.right"' in second
    assert '\nchannel = "a.right"' in draft_vehicle(robot_findings, None, "right").split("[[encoder]]")[1]


def test_the_draft_comments_out_what_is_not_known(robot_findings):
    text = draft_vehicle(robot_findings, None, None)
    assert "# bitrate" in text
    assert '# channel = "a.left"' in text
    assert "# counts_per_turn" in text
    assert "sync_period = 0.02 " in text


def test_two_wheels_that_never_move_are_no_wheels():
    rows = [Frame(0.01 * n, can_id, bytes(4)) for n in range(900) for can_id in (0x185, 0x186)]
    findings = learn_bus(frames_of([*rows, Frame(9.1, 0x705, b"\5"), Frame(9.1, 0x706, b"\5")]))
    assert findings.kinematics.wheels == ()
    assert "is not identified" in findings.kinematics.reasons[0]


def test_a_robot_that_only_turns_on_the_spot_may_be_one_that_drives_straight():
    time = np.arange(0, 40, 0.02)
    angle = np.cumsum(np.convolve(np.where(time < 35, 4.0, 0.0), np.ones(20) / 20, "same")) * 0.02
    rows = [Frame(t, 0x80, b"") for t in time.tolist()]
    for node, sign in ((5, 1), (6, -1)):
        counts = np.floor(sign * 3000 * angle).astype(int).tolist()
        rows += [
            Frame(t + 0.001, 0x180 + node, (c % 2**32).to_bytes(4, "little"))
            for t, c in zip(time, counts, strict=True)
        ]
        rows += [Frame(t + 0.5, 0x700 + node, b"\5") for t in range(39)]
    kinematics = learn_bus(in_order(rows)).kinematics
    assert [wheel.side for wheel in kinematics.wheels] == [0, 1]
    assert kinematics.turn_starts == ()


def test_cantools_reads_the_dbc_and_decodes_the_values(robot_findings):
    meanings = meanings_of(robot_findings)
    database = cantools.database.load_string(learned_dbc(robot_findings, meanings), "dbc")
    for each in robot_findings.messages:
        message = database.get_message_by_frame_id(each.message.can_id)
        decoded = message.decode(each.message.data[700 if len(each.message.data) > 700 else 0].tobytes())
        for signal in each.signals:
            row = 700 if len(signal.raw) > 700 else 0
            expected = signal.values()[row]
            assert decoded[meanings[signal.label].name] == pytest.approx(expected)


def test_cantools_reads_big_endian_signals_as_they_were_learned():
    random = np.random.default_rng(2)
    values = np.rint(9000 + 3000 * np.sin(np.arange(2000) / 40) + random.normal(0, 1, 2000)).astype(int)
    others = np.rint(500 * np.cos(np.arange(2000) / 31) + random.normal(0, 1, 2000)).astype(int)
    rows = [
        Frame(0.01 * n, 0x0AA, int(v).to_bytes(2, "big") + int(w % 65536).to_bytes(2, "big"))
        for n, (v, w) in enumerate(zip(values, others, strict=True))
    ]
    findings = learn_bus(frames_of(rows))
    meanings = meanings_of(findings)
    database = cantools.database.load_string(learned_dbc(findings, meanings), "dbc")
    decoded = database.get_message_by_frame_id(0x0AA).decode(rows[77].data)
    assert sorted(decoded.values()) == [others[77], values[77]]


def test_a_mapping_that_sdo_traffic_shows_counts_before_statistics():
    known = {0x185: (Signal("5.6064h Position actual value", 0, 32, signed=True), Signal("5.2099h", 32, 16))}
    findings = learn_bus(robot_log(), known)
    first, second = message_of(findings, 0x185).signals
    assert (first.signed, first.boundaries_probability, first.name) == (
        True,
        1.0,
        "5.6064h Position actual value",
    )
    assert (second.start, second.bits) == (32, 16)
    assert meanings_of(findings)[first.label].name == "Position_actual_value_0"


@pytest.mark.slow
@given(st.data())
@settings(max_examples=30, deadline=None)
def test_whatever_is_on_the_bus_is_learned_without_an_exception(data):
    random = np.random.default_rng(data.draw(st.integers(0, 2**32)))
    rows = []
    for can_id in data.draw(
        st.lists(st.sampled_from([0, 0x80, 0x81, 0x100, 0x185, 0x205, 0x585, 0x605, 0x705]))
    ):
        count = data.draw(st.sampled_from([1, 2, 3, 9, 40]))
        length = data.draw(st.integers(0, 8))
        flags = data.draw(st.sampled_from([0, 0, 0, EXTENDED, REMOTE]))
        span = data.draw(st.sampled_from([1, 2, 256]))
        for time in np.sort(np.round(random.uniform(0, 5, count), 2)).tolist():
            payload = (
                b""
                if flags & REMOTE
                else random.integers(0, span, length, np.uint16).astype(np.uint8).tobytes()
            )
            rows.append(Frame(time, can_id, payload, flags, length))
    if not rows:
        return
    findings = learn_bus(in_order(rows))
    meanings = meanings_of(findings)
    cantools.database.load_string(learned_dbc(findings, meanings), "dbc")
    assert max(map(len, report_lines(findings, meanings))) <= WIDTH
    draft_vehicle(findings, None, "left")
    json.dumps(findings_as_json(findings, meanings))


def test_the_report_fits_80_columns_and_says_why(robot_findings):
    lines = list(report_lines(robot_findings, meanings_of(robot_findings)))
    assert max(map(len, lines)) <= WIDTH
    text = " ".join(" ".join(lines).split())
    assert "have a constant ratio" in text
    assert "whose differences are the same with any sign" in text


def test_json_has_what_the_report_has(robot_findings):
    document = findings_as_json(robot_findings, meanings_of(robot_findings))
    assert [node["number"] for node in document["nodes"]] == [5, 6]
    assert len(document["wheels"]) == 2
    signal = document["messages"][0]["signals"][0]
    assert (signal["start_bit"], signal["bits"], signal["sure"]) == (0, 32, True)


def test_a_multiplexor_is_found_with_what_it_switches_and_cantools_decodes_it():
    random = np.random.default_rng(5)
    count = 1200
    slow = np.rint(3000 + 900 * np.sin(np.arange(count) / 60) + random.normal(0, 2, count)).astype(int)
    fast = np.rint(400 * np.cos(np.arange(count) / 9)).astype(int)
    rows = []
    for n in range(count):
        body = (
            b"\x01" + int(slow[n]).to_bytes(2, "little") + bytes(1)
            if n % 2
            else b"\x02" + bytes([n // 200 % 2]) + int(fast[n] % 65536).to_bytes(2, "little")
        )
        rows.append(Frame(0.02 * n, 0x185, body))
    rows += [Frame(t + 0.005, 0x705, b"\x05") for t in range(24)]
    findings = learn_bus(in_order(rows))
    signals = {(s.multiplexor_value, s.start, s.bits): s for s in message_of(findings, 0x185).signals}
    assert signals[None, 0, 8].kind == "multiplexor"
    assert {(2, 16, 16), (2, 8, 8)} <= set(signals)
    assert any(key[:2] == (1, 8) for key in signals)
    meanings = meanings_of(findings)
    database = cantools.database.load_string(learned_dbc(findings, meanings), "dbc")
    decoded = database.get_message_by_frame_id(0x185).decode(rows[0].data)
    assert decoded[meanings[signals[2, 16, 16].label].name] == fast[0]


def drive_log(signals, status=0x0237, start=0):
    """Return a log of a drive that sends a status word, and 32 bits ten times a second."""
    times = np.arange(0.0, 60.0, 0.2)
    speed = np.where(times % 12 < 8, 5000.0, 0.0) * np.where(times % 24 < 12, 1.0, -0.3)
    speed = np.rint(np.convolve(speed, np.ones(6) / 6, "same")).astype(np.int64)
    values = {"speed": speed, "position": np.cumsum(speed) + start}[signals]
    rows = [Frame(float(t), 0x705, b"\x05") for t in np.arange(0.0, 60.0, 0.5)]
    for t, value in zip(times.tolist(), values.tolist(), strict=True):
        data = status.to_bytes(2, "little") + (value % 2**32).to_bytes(4, "little")
        rows.append(Frame(t + 0.001, 0x185, data))
    return in_order(rows)


def test_the_speed_of_a_drive_whose_status_word_never_changes_is_signed():
    signals = message_of(learn_bus(drive_log("speed")), 0x185).signals
    assert [(s.kind, s.signed) for s in signals] == [("status word", None), ("number", True)]


def test_the_sign_of_a_number_that_swings_is_left_open_where_its_node_is_no_drive():
    signals = message_of(learn_bus(drive_log("speed", status=0x1802)), 0x185).signals
    assert [(s.kind, s.signed) for s in signals] == [("constant", None), ("number", None)]


def test_a_position_of_a_drive_that_passes_0_once_may_be_a_vendors_counter():
    signals = message_of(learn_bus(drive_log("position", start=-9000)), 0x185).signals
    assert (signals[-1].kind, signals[-1].signed) == ("number", None)


@pytest.mark.parametrize(("start", "is_crossing"), [(-9000, True), (-900_000, False)])
def test_the_reason_of_a_sign_speaks_of_crossing_0_only_where_0_was_crossed(start, is_crossing):
    [*_, position] = message_of(learn_bus(drive_log("position", start=start)), 0x185).signals
    assert any("crosses 0" in reason for reason in position.reasons) == is_crossing


@pytest.mark.parametrize(
    ("name", "bits", "kind", "signed"),
    [
        ("5.6030h:01", 16, "number", True),
        ("5.6040h:01", 16, "number", True),
        ("5.6040h Controlword", 16, "control word", None),
        ("5.6004h Position value", 32, "number", False),
        ("5.60FAh", 32, "number", True),
        ("5.6060h Modes of operation", 8, "bits", None),
    ],
)
def test_an_object_of_a_profile_is_what_the_profile_says_whatever_its_values_look_like(
    name, bits, kind, signed
):
    known = {0x185: (Signal(name, 16, bits),)}
    signal = message_of(learn_bus(drive_log("speed", status=0x1802), known), 0x185).signals[0]
    assert (signal.kind, signal.signed, signal.is_sure) == (kind, signed, True)


def test_an_object_with_a_width_of_its_own_is_learned_from_its_values():
    known = {0x185: (Signal("5.6064h Position actual value", 16, 16),)}
    signal = message_of(learn_bus(drive_log("speed"), known), 0x185).signals[0]
    assert "status word" != signal.kind != "constant"


@pytest.mark.parametrize(
    ("values", "is_open"),
    [
        (np.arange(3000) * 5 + 100, True),  # 15000 counts: the low two bytes alone move
        (np.arange(3000) * 41 + 100, False),  # 123000 counts: more than 16 bits move
    ],
)
def test_a_number_whose_upper_bytes_never_move_may_be_narrower_and_is_not_sure(values, is_open):
    random = np.random.default_rng(5)
    noisy = values + random.integers(-1, 2, len(values)) + 8
    rows = [Frame(float(t), 0x705, b"\x05") for t in np.arange(0.0, 60.0, 0.5)]
    rows += [
        Frame(0.02 * n + 0.001, 0x185, int(value).to_bytes(4, "little"))
        for n, value in enumerate(noisy.tolist())
    ]
    (signal,) = message_of(learn_bus(in_order(rows)), 0x185).signals
    assert (signal.bits, signal.kind) == (32, "number")
    assert signal.is_sure != is_open
