"""The mapping that a log shows, and the EDS that names its objects, decode a device's PDOs."""

from pathlib import Path

from omnimate.driver.canopen.eds import load_eds
from omnimate.driver.canopen.mapped_signals import default_objects, mapped_signals
from omnimate.files.logs.decoding import FrameDecoder
from omnimate.files.logs.frames import EXTENDED, Frame, frames_of
from omnimate.files.logs.seen_mapping import SeenObjects, mapped_objects, seen_objects

EDS = Path(__file__).parents[3] / "vcan_sim" / "eds"


def download(node, index, subindex, value, size):
    head = bytes([0x23 | (4 - size) << 2]) + index.to_bytes(2, "little") + bytes([subindex])
    return Frame(0.0, 0x600 + node, head + value.to_bytes(4, "little"))


def uploaded(node, index, subindex, value):
    head = b"\x43" + index.to_bytes(2, "little") + bytes([subindex])
    return Frame(0.0, 0x580 + node, head + value.to_bytes(4, "little"))


def test_what_a_master_writes_and_reads_is_the_mapping():
    frames = frames_of(
        [
            download(5, 0x1A00, 0, 0, 1),
            download(5, 0x1A00, 1, 0x60040020, 4),
            download(5, 0x1A00, 2, 0x60300110, 4),
            download(5, 0x1A00, 0, 2, 1),
            uploaded(6, 0x1A01, 1, 0x60640020),
            uploaded(6, 0x1801, 1, 0x40000399),
            Frame(0.0, 0x586, b"\x80\x00\x1a\x03" + bytes(4)),
        ]
    )
    pdos = mapped_objects(seen_objects(frames))
    assert pdos.keys() == {0x185, 0x399}
    assert [(e.object, e.subindex, e.start_bit, e.bits) for e in pdos[0x185]] == [
        (0x6004, 0, 0, 32),
        (0x6030, 1, 32, 16),
    ]
    names = {cob_id: [signal.name for signal in carried] for cob_id, carried in mapped_signals(
        seen_objects(frames), {}
    ).items()}  # fmt: skip
    assert names == {
        0x185: ["5.6004h Position value", "5.6030h:01"],
        0x399: ["6.6064h Position actual value"],
    }


def test_a_pdo_that_is_switched_off_or_maps_nothing_has_no_signals():
    objects = {(5, 0x1800, 1): 0x80000185, (5, 0x1A00, 1): 0x60040020, (5, 0x1A01, 0): 0}
    assert mapped_objects(objects) == {}


def test_an_eds_gives_the_mapping_after_power_on_with_names_and_signs():
    dictionary = load_eds(EDS / "drive_cia402.eds", 11).dictionary
    signals = mapped_signals(default_objects(dictionary, 11), {11: dictionary})
    [status] = signals[0x18B]
    assert (status.name, status.bits, status.signed) == ("11.6041h Statusword", 16, False)
    objects = default_objects(dictionary, 11) | {(11, 0x1801, 1): 0x28B}
    position, speed = mapped_signals(objects, {11: dictionary})[0x28B]
    assert (position.signed, speed.signed, speed.start_bit) == (True, True, 32)


def test_a_pdo_that_a_dcf_sets_to_zero_objects_has_no_signals(tmp_path):
    text = (EDS / "encoder_cia406.eds").read_text("cp1252")
    [entries] = [section for section in text.split("[") if section.lower().startswith("1a00sub0]")]
    path = tmp_path / "encoder.dcf"
    path.write_text(text.replace(entries, f"{entries.rstrip()}\nParameterValue=0\n\n"))
    dictionary = load_eds(path, 5).dictionary
    assert dictionary[0x1A00][0].default
    assert 0x185 not in mapped_signals(default_objects(dictionary, 5), {})


def test_a_pdo_with_29_bits_is_decoded_by_all_of_them_and_no_11_bit_one_instead():
    objects = {(5, 0x1800, 1): 0x38FF0185, (5, 0x1A00, 1): 0x60040020}
    [(key, carried)] = mapped_signals(objects, {}).items()
    decoder = FrameDecoder(None, {key: carried})
    position = bytes([7, 0, 0, 0])
    assert decoder(Frame(0.0, 0x18FF0185, position, EXTENDED)) == "5.6004h Position value = 7"
    assert decoder(Frame(0.0, 0x185, position)) == "TPDO1 of node 5"


REFUSED = Frame(0.0, 0x585, b"\x80\x00\x1a\x01" + (0x06040041).to_bytes(4, "little"))


def test_a_mapping_that_the_node_refuses_is_not_taken_also_if_the_answer_is_in_another_block():
    frames = [download(5, 0x1A00, 1, 0x60040020, 4), REFUSED, download(5, 0x1A01, 1, 0x60640020, 4)]
    assert mapped_objects(seen_objects(frames_of(frames))).keys() == {0x285}
    seen = SeenObjects()
    for frame in frames:
        seen.take(frames_of([frame]))
    assert mapped_objects(seen.values).keys() == {0x285}


def test_a_mapping_that_the_node_has_confirmed_outlives_a_refusal_to_change_or_to_read_it():
    confirmed = Frame(0.0, 0x585, b"\x60\x00\x1a\x01" + bytes(4))
    read = Frame(0.0, 0x605, b"\x40\x00\x1a\x01" + bytes(4))
    taken = [download(5, 0x1A00, 1, 0x60040020, 4), confirmed]
    for refused in ([download(5, 0x1A00, 1, 0x60640020, 4), REFUSED], [read, REFUSED]):
        assert seen_objects(frames_of([*taken, *refused])) == {(5, 0x1A00, 1): 0x60040020}
