"""Studies: verbs whose code is in a checkout of the source and not in the installed package."""

from __future__ import annotations

from importlib.util import find_spec

from omnimate.vehicle.errors import OmnimateError


class NoCheckoutError(OmnimateError):
    """A study that was asked for where its code is not.

    Attributes:
        verb: The verb that was called.
    """

    def __init__(self, verb: str) -> None:
        super().__init__(
            f"omnimate {verb} is a study, which runs from a checkout of the source; "
            "the installed package does not hold it"
        )
        self.verb = verb


def check_checkout(verb: str, room: str) -> None:
    """Check that the room of a study is there.

    Raises:
        NoCheckoutError: This is an installed package.
    """
    if find_spec(f"omnimate.{room}") is None:
        raise NoCheckoutError(verb)
