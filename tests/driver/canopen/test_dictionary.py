"""The standard dictionary has the widths of CiA 301, 402 and 406, as EDS files state them."""

from pathlib import Path

import pytest

from omnimate.driver.canopen.dictionary import ARRAYS, VARIABLES, standard_dictionary
from omnimate.driver.canopen.eds import load_eds

OTHER_MEANING = {"drive_cia402": {0x6502}}  # supported drive modes; the number of turns in CiA 406
FILES = sorted((Path(__file__).parents[3] / "vcan_sim" / "eds").glob("*.eds"))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_each_object_is_as_wide_as_in_the_eds_files(path):
    standard, device = standard_dictionary(), load_eds(path, 1).dictionary
    shared = {index for index in VARIABLES if index in device} - OTHER_MEANING.get(path.stem, set())
    assert len(shared) >= 8
    for index in shared:
        assert len(standard[index]) == len(device[index]), f"{index:04X}h"


def test_there_are_eds_files_to_compare_with():
    assert len(FILES) >= 3


@pytest.mark.parametrize("base", [0x1400, 0x1600, 0x1800, 0x1A00])
def test_the_four_pdos_of_the_predefined_connection_set_are_there(base):
    dictionary = standard_dictionary()
    assert [index for index in dictionary if base <= index < base + 0x200] == [base + n for n in range(4)]


def test_every_entry_of_an_array_has_the_width_of_the_array():
    dictionary = standard_dictionary()
    for index, (_, data_type) in ARRAYS.items():
        assert dictionary.get_variable(index, 0).data_type != data_type or index == 0
        assert dictionary.get_variable(index, 1).data_type == data_type
