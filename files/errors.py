"""The errors of importers and exporters."""

from __future__ import annotations

from omnimate.vehicle.errors import InputError


class SourceError(InputError):
    """A file or a bag that cannot be converted to a recording.

    Attributes:
        source: The file, with line and column where they are known, or the topic of a bag.
    """


class MappingError(SourceError):
    """A mapping that does not say which column or topic holds which quantity."""


class ExportError(SourceError):
    """Data that a format cannot hold, or a missing library of it; `source` is the file to be written."""
