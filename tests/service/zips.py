"""Zip files of what a test names."""

import io
import zipfile


def zipped(members):
    """Return a zip of members, given as name (or `ZipInfo`) and content, which may be a dictionary."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items() if isinstance(members, dict) else members:
            archive.writestr(name, content)
    return buffer.getvalue()
