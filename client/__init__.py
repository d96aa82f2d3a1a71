"""The Python client of the REST service: typed calls, generated from its OpenAPI document.

`Client("http://127.0.0.1:8080")` has the service's operations in groups. It needs no library of the service.
"""

from omnimate.client.client import Client
from omnimate.client.errors import ProblemError, UnreachableError, UrlError

__all__ = ["Client", "ProblemError", "UnreachableError", "UrlError"]
