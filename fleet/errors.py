"""The errors of a night's work."""

from omnimate.vehicle.errors import OmnimateError


class FleetError(OmnimateError):
    """A store, results or a request that a night's work cannot go on with.

    Attributes:
        source: Store, file or robot that the problem is in.
    """

    def __init__(self, source: object, problem: str) -> None:
        super().__init__(f"{source}: {problem}")
        self.source = str(source)
