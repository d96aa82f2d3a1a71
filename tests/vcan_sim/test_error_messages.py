"""The messages for broken input, whole and word for word, as the tables under `tests/data/` have them."""

import pytest

from omnimate.effects.errors import EffectsFileError
from omnimate.effects.file import parse_effects
from omnimate.vcan_sim.errors import BumpError, FaultError, ProtocolError
from omnimate.vcan_sim.faults import parse_fault
from omnimate.vcan_sim.floor import parse_bump
from omnimate.vcan_sim.socketcand import parse_send
from tests.samples import broken


def parse_file(text):
    return parse_effects(text, "robot/effects.toml")


def cases(table, parse, error):
    rows = broken(f"vcan_sim/{table}")
    return [pytest.param(parse, error, row["input"], row["message"], id=row["message"]) for row in rows]


@pytest.mark.parametrize(
    ("parse", "error", "text", "message"),
    [
        *cases("broken_faults.toml", parse_fault, FaultError),
        *cases("broken_bumps.toml", parse_bump, BumpError),
        *cases("broken_effects.toml", parse_file, EffectsFileError),
        *cases("broken_sends.toml", parse_send, ProtocolError),
    ],
)
def test_broken_input_is_answered_with_its_message(parse, error, text, message):
    with pytest.raises(error) as caught:
        parse(text)
    assert str(caught.value) == message
