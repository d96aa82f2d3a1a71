"""HTTP calls of the service: requests, repetitions, problem details, pages and streams."""

from __future__ import annotations

import json
import time
import uuid
from contextlib import contextmanager
from dataclasses import dataclass
from http.client import HTTPException
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict
from urllib.error import HTTPError, URLError
from urllib.parse import quote, urlencode
from urllib.request import Request, urlopen

from omnimate.client.errors import ProblemError, UnreachableError, UrlError
from omnimate.files.recordings.zipped import pack

if TYPE_CHECKING:
    import ssl
    from collections.abc import Iterator, Mapping
    from http.client import HTTPResponse
    from typing import Unpack

    from omnimate.client.models import Problem

REPEATED_STATUSES = {429, 503}  # too many calls; not available now: the call was not carried out
PAUSE = 1.0  # [s] before a repetition where the service names no time


class Options(TypedDict, total=False):
    """The parts of a request."""

    query: Mapping[str, object]  # parameters; those that are None are left out
    body: object  # sent as JSON
    content: tuple[str, bytes]  # media type and content of any other body
    key: str | None  # Idempotency-Key; None for a new one. A call without this part may not be repeated
    if_match: str | int  # ETag of the version that is changed, with or without quotes


@dataclass(frozen=True, slots=True)
class Event:
    """An event of a stream (`text/event-stream`)."""

    kind: str  # its type, such as `state`
    data: Any  # from JSON


@dataclass(frozen=True, slots=True)
class Transport:
    """Calls of one service, with the arguments of `Client`."""

    url: str
    key: str | None
    timeout: float
    patience: float
    context: ssl.SSLContext | None

    def __post_init__(self) -> None:
        """Check the URL; UrlError where it is neither http nor https."""
        if not self.url.startswith(("http://", "https://")):
            raise UrlError(self.url)

    def json(self, method: str, path: str, **options: Unpack[Options]) -> Any:  # noqa: ANN401  # by operation
        """Return an answer of JSON.

        Raises:
            ProblemError: the service refused the call.
            UnreachableError: there was no answer.
        """
        return json.loads(self.data(method, path, **options))

    def text(self, method: str, path: str, **options: Unpack[Options]) -> str:
        """Return an answer of text; raises as `json`."""
        return self.data(method, path, **options).decode()

    def data(self, method: str, path: str, **options: Unpack[Options]) -> bytes:
        """Return the content of an answer; raises as `json`.

        A call that changes nothing, or that has an Idempotency-Key, is repeated where the service asks for
        that by 429 or 503, and where its answer was lost.
        """
        request = self._request(method, path, options)
        repeatable = method == "GET" or "key" in options
        end = time.monotonic() + self.patience
        while True:
            try:
                with self._opened(request) as response:
                    return response.read()
            except (ProblemError, OSError, HTTPException) as error:
                pause = _pause(error) if repeatable else None
                if pause is None or time.monotonic() + pause > end:
                    raise _explained(error, request) from error
            time.sleep(pause)

    def pages(self, path: str, query: Mapping[str, object]) -> Iterator[Any]:
        """Yield the items of all pages of a list; raises as `json`, when the first item is read."""
        after = None
        while True:
            page = self.json("GET", path, query={**query, "after": after})
            yield from page["items"]
            after = page["next"]
            if after is None:
                return

    def lines(self, path: str, query: Mapping[str, object]) -> Iterator[str]:
        """Yield the lines of a stream until it ends; raises as `json`, when the first line is read."""
        request = self._request("GET", path, {"query": query})
        try:
            with self._opened(request) as response:
                for line in response:
                    yield line.decode().rstrip("\r\n")
        except (ProblemError, OSError, HTTPException) as error:
            raise _explained(error, request) from error

    def events(self, path: str, query: Mapping[str, object]) -> Iterator[Event]:
        """Yield the events of a stream until it ends; raises as `lines`.

        Source of the format: HTML Living Standard, section 9.2.6; the service sends `event` and `data`.
        """
        kind, data = "", ""
        for line in self.lines(path, query):
            field, _, value = line.partition(": ")
            if field == "event":
                kind = value
            elif field == "data":
                data += value
            elif not line and data:
                yield Event(kind, json.loads(data))
                kind, data = "", ""

    def _request(self, method: str, path: str, options: Options) -> Request:
        given = {name: value for name, value in options.get("query", {}).items() if value is not None}
        query = urlencode({name: _shown(value) for name, value in given.items()})
        url = self.url.rstrip("/") + path + ("?" + query if query else "")
        headers, content = {}, None
        if "body" in options:
            headers["Content-Type"], content = "application/json", json.dumps(options["body"]).encode()
        elif "content" in options:
            headers["Content-Type"], content = options["content"]
        if "key" in options:
            headers["Idempotency-Key"] = options["key"] or uuid.uuid4().hex
        if "if_match" in options:
            headers["If-Match"] = _etag(options["if_match"])
        request = Request(url, content, headers, method=method)  # noqa: S310  # http or https: __post_init__
        if self.key is not None:  # not sent to another host to which the service might redirect
            request.add_unredirected_header("Authorization", f"Bearer {self.key}")
        return request

    @contextmanager
    def _opened(self, request: Request) -> Iterator[HTTPResponse]:
        """Open the answer to a request; ProblemError where it is a problem."""
        try:
            response = urlopen(request, timeout=self.timeout, context=self.context)  # noqa: S310  # as above
        except HTTPError as error:
            with error:
                raise _problem_of(error) from error
        with response:
            yield response


def part(value: object) -> str:
    """Return a value as a part of a path."""
    return quote(str(value), safe="")


def zip_content(source: str | Path | bytes) -> tuple[str, bytes]:
    """Return the media type and the content of a zip: packed from a folder, a file, or as it is."""
    if isinstance(source, bytes):
        return "application/zip", source
    path = Path(source)
    return "application/zip", pack(path) if path.is_dir() else path.read_bytes()


def _shown(value: object) -> str:
    """Return a query parameter as the service reads it."""
    return str(value).lower() if isinstance(value, bool) else str(value)


def _etag(version: str | int) -> str:
    """Return an ETag; `*` and what has quotes already stay as they are."""
    text = str(version)
    return text if text == "*" or text.endswith('"') else f'"{text}"'


def _problem_of(error: HTTPError) -> ProblemError:
    """Return the problem that an answer holds; from its status where a proxy has answered."""
    content, after = error.read(), error.headers.get("Retry-After", "")
    detail = content.decode(errors="replace")[:1000]
    problem: Problem = {"status": error.code, "title": error.reason, "detail": detail}
    if error.headers.get_content_type() == "application/problem+json":
        problem.update(json.loads(content))
    return ProblemError(problem, float(after) if after.isdecimal() else None)


def _pause(error: Exception) -> float | None:
    """Return the time after which to repeat a call [s]; None where that is of no use."""
    if isinstance(error, ProblemError):
        pause = PAUSE if error.retry_after is None else error.retry_after
        return pause if error.status in REPEATED_STATUSES else None
    return None if isinstance(error, URLError) else PAUSE  # URLError: nothing answers at this address


def _explained(error: Exception, request: Request) -> Exception:
    """Return the error that a caller sees."""
    if isinstance(error, ProblemError):
        return error
    return UnreachableError(request.full_url, str(getattr(error, "reason", error)) or type(error).__name__)
