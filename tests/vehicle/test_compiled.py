"""Compiled functions and their records."""

import os
from typing import Annotated

import numpy as np

from vehicle import compiled as module
from vehicle.compiled import Array, IntArray, compiled, layout, record


class Fields:
    number: int
    value: float
    place: Annotated[Array, (2, 3)]
    counts: Annotated[IntArray, 4]


def test_a_record_has_the_annotated_fields_in_their_order_and_shape():
    kind = layout(Fields)
    assert kind.names == ("number", "value", "place", "counts")
    assert kind["number"] == np.int64
    assert kind["value"] == np.float64
    assert (kind["place"].shape, kind["counts"].shape) == ((2, 3), (4,))
    assert kind["counts"].base == np.int64


def test_a_new_record_is_one_and_all_zero():
    one = record(Fields)
    assert one.shape == (1,)
    assert one["place"].sum() == 0.0


@compiled
def double(records):
    records[0].value = 2.0 * records[0].value
    records[0].place[1, 2] = records[0].value


def test_a_compiled_function_changes_the_record_it_is_given():
    one = record(Fields)
    one["value"] = 1.5
    double(one)
    assert one["value"][0] == 3.0
    assert one["place"][0, 1, 2] == 3.0


def test_what_was_compiled_before_a_source_changed_is_dropped(tmp_path):
    """numba would keep it, because the file of the calling function itself is older."""
    kept = tmp_path / "__pycache__"
    kept.mkdir()
    stale, fresh = kept / "stale.nbi", kept / "fresh.nbi"
    source = tmp_path / "callee.py"
    for path, date in ((stale, 1.0), (source, 2.0), (fresh, 4e9)):
        path.write_text("")
        os.utime(path, (date, date))
    module._forget_stale(tmp_path)
    assert not stale.exists()
    assert fresh.exists()
