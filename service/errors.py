"""The errors of this room: each is a problem detail (RFC 9457) with a status of HTTP."""

from __future__ import annotations

from vehicle.errors import OmnimateError


class ServiceError(OmnimateError):
    """Something that the service cannot do; `status` is what HTTP calls it."""

    status = 500
    title = "The service cannot do this"
    headers: dict[str, str] = {}  # noqa: RUF012  # overridden as a whole, never changed


class NotThereError(ServiceError):
    """Something that is asked for and is not there."""

    status, title = 404, "Not there"

    def __init__(self, what: str, name: str) -> None:
        super().__init__(f"there is no {what} {name!r}; GET the list to see which there are")


class StateError(ServiceError):
    """A call that the state of a thing does not allow.

    Attributes:
        possible: the calls that it does allow.
    """

    status, title = 409, "Not in this state"

    def __init__(self, problem: str, possible: tuple[str, ...] = ()) -> None:
        calls = f"; possible now: {', '.join(possible)}" if possible else ""
        super().__init__(problem + calls)
        self.possible = possible


class ExpiredError(ServiceError):
    """A session that nobody went on with in time."""

    status, title = 410, "Expired"


class ChangedError(ServiceError):
    """If-Match names what has been replaced since."""

    status, title = 412, "Changed since"


class ValueProblem(ServiceError):  # noqa: N818  # the title of its status
    """A value that no robot and no room can have.

    Attributes:
        where: in what was sent.
        problem: with it.
    """

    status, title = 422, "Not usable"

    def __init__(self, where: str, problem: str) -> None:
        super().__init__(f"{where}: {problem}")
        self.where, self.problem = where, problem


class KeyProblem(ServiceError):  # noqa: N818
    """No key, or a wrong one."""

    status, title = 401, "A key is needed"
    headers = {"WWW-Authenticate": "Bearer"}  # noqa: RUF012


class RoleProblem(ServiceError):  # noqa: N818
    """A key that may not do this."""

    status, title = 403, "Not allowed"


class TooLargeError(ServiceError):
    """More than the service takes."""

    status, title = 413, "Too large"


class MediaProblem(ServiceError):  # noqa: N818
    """A body of another kind than expected."""

    status, title = 415, "Of another kind"


class TooManyError(ServiceError):
    """More calls than the service answers one caller."""

    status, title = 429, "Too many calls"
    headers = {"Retry-After": "1"}  # noqa: RUF012


class AbsentError(ServiceError):
    """Something that the service needs is not there now."""

    status, title = 503, "Not now"
    headers = {"Retry-After": "2"}  # noqa: RUF012
