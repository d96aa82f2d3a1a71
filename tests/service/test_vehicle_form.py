"""The limits of the form on the page are those of `vehicle.toml`."""

import re
from pathlib import Path

import pytest

from omnimate.vehicle.parameters import Linkage, ParameterError, Truck

FORM = (Path(__file__).parents[2] / "service/page/vehicle-edit.js").read_text(encoding="utf-8")
SIZES = {"wheelbase": 0.34, "wheel_diameter_left": 0.15, "wheel_diameter_right": 0.15}
DIAMETER = re.search(r"const DIAMETER = (\[.*?\]);", FORM)[1]
LIMITS = re.search(r"const LIMITS = \{(.*?)\};", FORM)[1].replace("DIAMETER", DIAMETER)


def made(key, value):
    """Return a truck or linkage with one size [m]."""
    return Linkage(value) if key == "length" else Truck(**SIZES | {key: value})


@pytest.mark.parametrize("key", [*SIZES, "length"])
def test_the_form_takes_what_a_vehicle_may_have_and_nothing_beyond(key):
    low, high = re.search(rf"\b{key}: \[([\d_]+), ([\d_]+)\]", LIMITS).groups()
    low, high = int(low) / 1000.0, int(high) / 1000.0
    assert made(key, low)
    assert made(key, high)
    for beyond in (0.999 * low, 1.001 * high):
        with pytest.raises(ParameterError, match="is impossible"):
            made(key, beyond)
