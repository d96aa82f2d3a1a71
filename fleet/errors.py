"""The errors of the fleet's daily run."""

from omnimate.vehicle.errors import OmnimateError


class FleetError(OmnimateError):
    """A store, results or a request that the daily run cannot process.

    Attributes:
        source: Store, file or robot with the problem.
    """

    def __init__(self, source: object, problem: str) -> None:
        super().__init__(f"{source}: {problem}")
        self.source = str(source)
