"""TOML tables as dataclasses."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from omnimate.vehicle.errors import TableError
from omnimate.vehicle.tables import dataclass_of, parse_toml, read_toml, value_of


@dataclass(frozen=True)
class Wheel:
    name: str
    diameter: float
    teeth: int | None = None
    driven: bool = True
    times: tuple[float, ...] = ()
    intervals: tuple[tuple[float, float], ...] = ()

    def __post_init__(self):
        if self.diameter <= 0.0:
            raise TableError("diameter", "expected more than 0")


def test_a_table_becomes_a_dataclass_with_its_lists_as_tuples():
    table = parse_toml(
        "name = 'left'\ndiameter = 1\nteeth = 20\ntimes = [1, 2.5]\nintervals = [[0, 1], [2, 3]]"
    )
    assert dataclass_of(Wheel, table, "wheel") == Wheel(
        "left", 1, 20, times=(1, 2.5), intervals=((0, 1), (2, 3))
    )


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (3, "wheel: 3; expected a table"),
        (
            {"name": "left", "diameter": 1.0, "size": 1},
            "wheel.size: unknown key; expected one of name, diameter",
        ),
        ({"name": "left"}, "wheel.diameter: missing; expected a number"),
        ({"name": "left", "diameter": True}, "wheel.diameter: True; expected a number"),
        ({"name": "left", "diameter": 0.0}, "wheel.diameter: expected more than 0"),
        ({"name": 1, "diameter": 1.0}, "wheel.name: 1; expected text"),
    ],
)
def test_a_wrong_table_is_refused_by_key_and_expectation(table, message):
    with pytest.raises(TableError) as caught:
        dataclass_of(Wheel, table, "wheel")
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize(
    ("annotation", "value", "words"),
    [
        ("float", 10**400, "a number"),
        ("int", 1.5, "a whole number"),
        ("int | None", "1", "a whole number"),
        ("bool", 1, "true or false"),
        ("tuple[float, ...]", 1.0, "a list of numbers"),
        ("tuple[float, ...]", ["1"], "a list of numbers"),
        ("tuple[tuple[float, float], ...]", [[1.0]], "a list of [start, end] pairs"),
        ("tuple[tuple[float, float], ...]", [1.0, 2.0], "a list of [start, end] pairs"),
    ],
)
def test_a_value_of_another_type_is_refused(annotation, value, words):
    with pytest.raises(TableError) as caught:
        value_of(annotation, value, "key")
    assert str(caught.value) == f"key: {value!r}; expected {words}"


@pytest.mark.parametrize(
    "value", ["[" * 5000, "9" * 5000, "0x" + "f" * 5000], ids=["depth", "digits", "hexadecimal digits"]
)
def test_more_levels_or_digits_than_python_reads_are_not_toml(value):
    with pytest.raises(TableError, match="not TOML"):
        parse_toml(f"a = {value}")


def test_a_file_that_cannot_be_read_or_is_not_toml_is_refused(tmp_path):
    path = tmp_path / "robot.toml"
    with pytest.raises(TableError, match=r"\(file\): cannot be read"):
        read_toml(path)
    path.write_bytes(b"name = '\xff'")
    with pytest.raises(TableError, match=r"\(file\): cannot be read"):
        read_toml(path)
    path.write_text("= 3")
    with pytest.raises(TableError, match=r"\(syntax\): not TOML"):
        read_toml(path)


def test_a_file_may_begin_with_a_byte_order_mark(tmp_path):
    (tmp_path / "robot.toml").write_bytes(b"\xef\xbb\xbfname = 'robot'")
    assert read_toml(tmp_path / "robot.toml") == {"name": "robot"}
