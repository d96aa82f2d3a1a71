"""The errors of the client."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from omnimate.client.models import Problem


class UrlError(OmnimateError):
    """The URL of a service that is none.

    Attributes:
        url: The URL.
    """

    def __init__(self, url: str) -> None:
        super().__init__(f"{url!r} is no URL of a service; expected one such as http://127.0.0.1:8080")
        self.url = url


class UnreachableError(OmnimateError):
    """The service cannot be reached, or its answer was lost.

    Attributes:
        url: The URL of the call.
        reason: What went wrong.
    """

    def __init__(self, url: str, reason: str) -> None:
        super().__init__(f"{url}: {reason}; is the service running, and is this its address?")
        self.url, self.reason = url, reason


class ProblemError(OmnimateError):
    """A call that the service refused, with its problem detail (RFC 9457).

    Attributes:
        status: The HTTP status: 409 in the wrong state, 412 changed since, 422 wrong values.
        type: The kind of problem as a URI, `about:blank` where the status says all.
        title: The kind of problem in words.
        detail: What was expected, and what to do.
        possible: The calls that the present state allows; empty where the service lists none.
        errors: The wrong fields as (field, problem); empty where the service lists none.
        request_id: X-Request-ID, by which the service's log names the call; None where there is none.
        retry_after: The time after which to try again [s]; None where the service gives none.
    """

    def __init__(self, problem: Problem, retry_after: float | None) -> None:
        super().__init__(f"{problem['status']} {problem['title']}: {problem['detail']}")
        self.status = problem["status"]
        self.type = problem.get("type", "about:blank")
        self.title = problem["title"]
        self.detail = problem["detail"]
        self.possible = tuple(problem.get("possible") or ())
        self.errors = tuple((error["where"], error["problem"]) for error in problem.get("errors") or ())
        self.request_id = problem.get("request_id")
        self.retry_after = retry_after
