"""Signals of DBC files are what cantools decodes, one frame at a time and for whole columns."""

import struct

import cantools
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.files.logs.dbc import read_dbc
from omnimate.files.logs.frames import Frame, frames_of
from omnimate.files.logs.signals import EXTENDED_KEY, Signal
from omnimate.vehicle.errors import LogError

HEAD = 'VERSION ""\n\nNS_ :\n\nBS_:\n\nBU_: host\n\n'


@st.composite
def layouts(draw):
    """Where a signal stands: start bit as DBC files count, width, byte order, sign."""
    bits = draw(st.integers(1, 64))
    lowest = draw(st.integers(0, 64 - bits))
    if draw(st.booleans()):
        return lowest, bits, 1, draw(st.sampled_from("+-"))
    highest = 64 - bits - lowest  # counted from the first bit of the first byte
    return highest // 8 * 8 + 7 - highest % 8, bits, 0, draw(st.sampled_from("+-"))


def files(tmp_path_factory, text):
    path = tmp_path_factory.mktemp("dbc") / "bus.dbc"
    path.write_text(HEAD + text)
    return path


@given(
    layout=layouts(),
    factor=st.sampled_from(["1", "0.5", "-2", "1E-3"]),
    offset=st.sampled_from(["0", "-40", "2.5"]),
    data=st.binary(min_size=8, max_size=8),
)
def test_a_number_is_what_cantools_decodes(tmp_path_factory, layout, factor, offset, data):
    start, bits, order, sign = layout
    line = f' SG_ level : {start}|{bits}@{order}{sign} ({factor},{offset}) [0|0] "m" host\n'
    path = files(tmp_path_factory, f"BO_ 385 tank: 8 host\n{line}")
    theirs = cantools.database.load_file(path).decode_message(385, data, decode_choices=False)["level"]
    [ours] = read_dbc(path)[385]
    assert ours.value(data) == pytest.approx(theirs, rel=1e-12, abs=1e-12)
    assert ours.values(frames_of([Frame(0.0, 385, data)]))[0] == pytest.approx(theirs, rel=1e-12, abs=1e-12)


def test_floats_choices_multiplexors_and_29_bit_identifiers(tmp_path_factory):
    text = (
        "BO_ 2566844894 speeds: 8 host\n"
        ' SG_ which M : 0|8@1+ (1,0) [0|0] "" host\n'
        ' SG_ left m0 : 8|32@1- (1,0) [0|0] "m/s" host\n'
        ' SG_ right m1 : 8|16@1- (0.01,0) [0|0] "m/s" host\n'
        "SIG_VALTYPE_ 2566844894 left : 1;\n"
        'VAL_ 2566844894 which 0 "left wheel; m/s" 1 "right wheel" ;\n'
    )
    path = files(tmp_path_factory, text)
    database, signals = cantools.database.load_file(path), read_dbc(path)
    assert signals.keys() == {0x18FEF1DE | EXTENDED_KEY} == {2566844894}
    left = [b"\0" + struct.pack("<f", value) + bytes(3) for value in (1.25, -1.25)]
    for data in (*left, b"\1" + struct.pack("<h", -250) + bytes(5)):
        there = [signal for signal in signals[2566844894] if signal.is_in(data)]
        theirs = database.decode_message(0x18FEF1DE, data, decode_choices=False)
        assert {signal.name: signal.value(data) for signal in there} == pytest.approx(theirs)
    frames = frames_of([Frame(0.0, 1, b"\0" + struct.pack("<f", 1.25)), Frame(0.0, 1, b"\1\0\0\0\0")])
    assert np.isnan(signals[2566844894][1].values(frames)).tolist() == [False, True]
    assert signals[2566844894][0].in_words(b"\1") == "which = right wheel (1)"


def test_messages_of_can_fd_are_no_reason_to_refuse_a_file(tmp_path_factory):
    long = 'BO_ 386 long: 64 host\n SG_ far : 100|8@1+ (1,0) [0|0] "" host\n'
    short = 'BO_ 385 short: 8 host\n SG_ near : 0|8@1+ (1,0) [0|0] "" host\n'
    signals = read_dbc(files(tmp_path_factory, long + short))
    assert {key: [signal.name for signal in carried] for key, carried in signals.items()} == {385: ["near"]}


@pytest.mark.parametrize("encoding", ["cp1252", "utf-8", "utf-8-sig"])
def test_units_and_words_are_read_in_the_encodings_of_windows_and_of_all_others(tmp_path, encoding):
    text = 'BO_ 385 oven: 1 host\n SG_ heat : 0|8@1+ (1,0) [0|0] "°C" host\nVAL_ 385 heat 9 "heiß" ;\n'
    (tmp_path / "bus.dbc").write_text(HEAD + text, encoding=encoding)
    [heat] = read_dbc(tmp_path / "bus.dbc")[385]
    assert (heat.unit, heat.choices) == ("°C", {9: "heiß"})


def test_the_words_of_a_raw_number_have_all_digits_of_64_bits():
    """A double has 53 bits: 433757350076175808 is another number."""
    assert Signal("key", 0, 64).in_words((433757350076175786).to_bytes(8, "little")) == (
        "key = 433757350076175786"
    )


def test_lines_on_what_is_not_in_the_file_are_no_reason_to_refuse_it(tmp_path_factory):
    """As where some messages were exported; cantools refuses each of these lines."""
    text = (
        'BO_ 385 tank: 8 host\n SG_ level : 0|8@1+ (1,0) [0|0] "" host\n'
        'BA_ "GenMsgCycleTime" BO_ 385 100;\nVAL_ 385 level 1 "one" ;\nVAL_ 385 gone 1 "one" ;\n'
        "SIG_VALTYPE_ 386 gone : 1;\n"
    )
    [level] = read_dbc(files(tmp_path_factory, text))[385]
    assert level.choices == {1: "one"}


@given(data=st.binary(min_size=8, max_size=8))
def test_a_multiplexor_that_is_multiplexed_itself_counts_as_cantools_counts_it(tmp_path_factory, data):
    text = (
        'BO_ 385 tank: 8 host\n SG_ page M : 0|2@1+ (1,0) [0|0] "" host\n'
        ' SG_ part m1M : 2|2@1+ (1,0) [0|0] "" host\n SG_ level m2 : 8|8@1+ (1,0) [0|0] "" host\n'
        "SG_MUL_VAL_ 385 part page 1-2;\nSG_MUL_VAL_ 385 level part 0-1, 3-3;\n"
    )
    path = files(tmp_path_factory, text)
    theirs = cantools.database.load_file(path)
    there = [signal for signal in read_dbc(path)[385] if signal.is_in(data)]
    columns = {signal.name: signal.values(frames_of([Frame(0.0, 385, data)]))[0] for signal in there}
    assert not np.isnan(list(columns.values())).any()
    try:
        expected = theirs.decode_message(385, data)
    except cantools.database.DecodeError:  # it expects a name for every value of a multiplexor
        return
    assert {signal.name: signal.value(data) for signal in there} == columns == expected


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("? no DBC at all", "line 9, column 1"),
        ("", "no message of up to 8 bytes in the file"),
        ('BO_ 385 x: 8 host\n SG_ y : 60|8@1+ (1,0) [0|0] "" host\n', "y of x .* does not fit 8 bytes"),
        ('BO_ 385 x: 8 host\n SG_ y : 0|8@1+ (a,0) [0|0] "" host\n', "line 10, column 18"),
        (
            'BO_ 385 x: 8 host\n SG_ y : 0|16@1+ (1,0) [0|0] "" host\nSIG_VALTYPE_ 385 y : 1;\n',
            "y of x with 16 bits from bit 0 is no float",
        ),
    ],
)
def test_a_broken_file_is_an_error_with_its_place(tmp_path_factory, text, problem):
    with pytest.raises(LogError, match=problem):
        read_dbc(files(tmp_path_factory, text))


@pytest.mark.parametrize("names", ["y z", "z q"])
def test_multiplexors_that_depend_on_each_other_or_on_nothing_are_read(tmp_path_factory, names):
    text = (
        'BO_ 385 x: 8 host\n SG_ y m1M : 0|8@1+ (1,0) [0|0] "" host\n'
        ' SG_ z m1M : 8|8@1+ (1,0) [0|0] "" host\n'
        f"SG_MUL_VAL_ 385 z y 1-1;\nSG_MUL_VAL_ 385 {names} 1-1;\n"
    )
    assert [signal.name for signal in read_dbc(files(tmp_path_factory, text))[385]] == ["y", "z"]


@given(data=st.binary(max_size=8), start=st.integers(0, 60), bits=st.integers(1, 64), signed=st.booleans())
def test_one_frame_and_whole_columns_agree_and_short_data_are_told(data, start, bits, signed):
    signal = Signal("level", start, min(bits, 64 - start), signed)
    [column] = signal.values(frames_of([Frame(0.0, 1, data)]))
    if len(data) < signal.length:
        assert np.isnan(column)
        assert "wrong length" in signal.in_words(data)
    else:
        assert column == pytest.approx(signal.value(data))
