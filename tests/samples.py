"""Sample files: ours in `tests/data`, and those of vendors and real robots in `../shared/data`."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

DATA = Path(__file__).parent / "data"
SHARED = Path(__file__).resolve().parents[2] / "shared"
SHARED_DATA = SHARED / "data"

# Of a simulated robot whose node ids are other than those of the reference robot.
OTHER_ROBOT = DATA / "logs" / "other_robot.log"
OTHER_ROBOT_ASC = DATA / "logs" / "other_robot.asc"

OUR_EDS = [DATA / "eds" / "encoder.eds", DATA / "eds" / "drive.dcf"]
VENDORS_EDS = [
    SHARED_DATA / "eds" / name
    for name in (
        "cia301_profile_kacanopen.eds",
        "cia406_profile_kacanopen.eds",
        "elmo_gold.dcf",
        "faulhaber_605.3150.71-A.eds",
        "lely_co-gw_txt-master.dcf",
        "maxon_epos2_347717.eds",
        "pilz_prbt_0_1.dcf",
        "sick_mls.eds",
    )
]
CANOPEN_TRACES = [
    SHARED_DATA / "real" / "canopen_traces_hilch" / name for name in ("ixxat1.trc.gz", "pcan1.trc.gz")
]
CAR_LOG = SHARED_DATA / "real" / "comma2k19_rav4" / "can_bus0.candump.log.gz"


def broken(table):
    """Return the cases of a table of broken input in `tests/data`, each with its whole message."""
    return tomllib.loads((DATA / table).read_text(encoding="utf-8"))["case"]


def cases(*rows):
    """Return pytest's parameters of rows that begin with a file; rows of `../shared/data` only where it is.

    A file that is missing in a folder that is there is not left out: its test fails.
    """
    rows = [row if isinstance(row, tuple) else (row,) for row in rows]
    return [
        pytest.param(*row, id="-".join(str(getattr(value, "name", value)) for value in row))
        for row in rows
        if SHARED_DATA.is_dir() or not row[0].is_relative_to(SHARED_DATA)
    ]
