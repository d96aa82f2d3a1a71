"""A diagnosis in a process of its own: it may use a core and a gigabyte, and may die."""

from __future__ import annotations

import json
import logging
import signal
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

_log = logging.getLogger(__name__)


def run(parent: Connection, named: list[tuple[str, str]]) -> None:
    """Diagnose recordings and tell the parent how far it is, and in the end what was found."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides
    from mismatch import diagnose
    from mismatch.report import render
    from vehicle.folder import load_recording

    def tell(done: int, total: int, doing: str) -> None:
        parent.send({"progress": done / total, "doing": doing})

    try:
        recordings = [replace(load_recording(Path(folder)), source=name) for name, folder in named]
        diagnosis = diagnose(recordings, progress=tell)
        parent.send(
            {
                "verdict": diagnosis.verdict,
                "says": diagnosis.says,
                "result": json.dumps(diagnosis.as_json()),
                "report": render(diagnosis),
            }
        )
    except OmnimateError as error:
        parent.send({"error": str(error)})
    except Exception as error:  # noqa: BLE001  # whoever waits must hear of it
        _log.exception("a diagnosis failed")
        parent.send({"error": f"an error of ours: {type(error).__name__}: {error}"})
