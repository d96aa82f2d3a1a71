"""The errors of this room; each becomes a problem detail (RFC 9457) with its HTTP status."""

from __future__ import annotations

from omnimate.vehicle.errors import OmnimateError


class ServiceError(OmnimateError):
    """A request that the service cannot fulfil."""

    status = 500
    title = "The service cannot do this"
    headers: dict[str, str] = {}  # noqa: RUF012  # overridden as a whole, never changed


class NotFoundError(ServiceError):
    """Something that was asked for does not exist."""

    status, title = 404, "Not there"

    def __init__(self, what: str, name: str) -> None:
        super().__init__(f"there is no {what} {name!r}; GET the list to see which there are")


class StateError(ServiceError):
    """A call that the present state does not allow, and those that it allows, where it is a session's."""

    status, title = 409, "Not in this state"

    def __init__(self, problem: str, possible: tuple[str, ...] | None = None) -> None:
        calls = f"; possible now: {', '.join(possible)}" if possible else ""
        super().__init__(problem + calls)
        self.possible = possible


class ExpiredError(ServiceError):
    """A session whose lifetime is over."""

    status, title = 410, "Expired"


class ModifiedError(ServiceError):
    """If-Match names a version that has been replaced since."""

    status, title = 412, "Changed since"


class InvalidValueError(ServiceError):
    """A value that is well-formed, but impossible for a robot."""

    status, title = 422, "Not usable"

    def __init__(self, where: str, problem: str) -> None:
        super().__init__(f"{where}: {problem}")
        self.where, self.problem = where, problem


class AuthenticationError(ServiceError):
    """A request without a valid API key."""

    status, title = 401, "A key is needed"
    headers = {"WWW-Authenticate": "Bearer"}  # noqa: RUF012


class ForbiddenError(ServiceError):
    """A request that the role of the key does not allow."""

    status, title = 403, "Not allowed"


class TooLargeError(ServiceError):
    """A body that is larger than the service accepts."""

    status, title = 413, "Too large"


class MediaTypeError(ServiceError):
    """A body of another media type than expected."""

    status, title = 415, "Of another kind"


class TooManyError(ServiceError):
    """One caller asks for more than is reserved for each."""

    status, title = 429, "Too many"
    headers = {"Retry-After": "30"}  # noqa: RUF012


class TooManyCallsError(ServiceError):
    """One caller makes more calls a second than are allowed."""

    status, title = 429, "Too many calls"
    headers = {"Retry-After": "1"}  # noqa: RUF012


class UnavailableError(ServiceError):
    """Something that the service needs is not available now."""

    status, title = 503, "Not now"
    headers = {"Retry-After": "2"}  # noqa: RUF012
