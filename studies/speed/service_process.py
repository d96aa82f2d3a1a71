"""A service in a process that benchmarks and tests can load and kill; it measures nothing itself."""

import re
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx2

from studies.benchmark import OMNIMATE

COMMAND = [*OMNIMATE, "serve", "--port", "0", "--rate", "1e6"]
PATIENCE = 120.0  # [s] that a slow machine may take to start it


class Service:
    def __init__(self, folder: Path | str, database: str, *options: str) -> None:
        began = time.perf_counter()
        with (Path(folder) / "serve.log").open("ab") as log:
            self.process = subprocess.Popen(
                [*COMMAND, "--database", database, *options],
                cwd=folder, stdout=subprocess.PIPE, stderr=log, text=True,
            )  # fmt: skip
        assert self.process.stdout is not None  # a pipe
        self._output = self.process.stdout
        line = self._output.readline()
        address = re.search(r"http://\S+", line)
        if address is None:
            raise RuntimeError(
                f"the service did not start: {(Path(folder) / 'serve.log').read_text()[-2000:]}"
            )
        self.url = address[0]  # address at which it listens
        self._wait(began)
        self.ready = time.perf_counter() - began  # time until /readyz answered 200 [s]

    def _wait(self, began: float) -> None:
        word = "no answer"
        with httpx2.Client(timeout=PATIENCE) as client:  # each new one would load the certificates again
            while time.perf_counter() - began < PATIENCE:
                try:
                    answer = client.get(f"{self.url}/readyz")
                    if answer.status_code == 200:
                        return
                    word = answer.text
                except httpx2.TransportError:
                    pass
                time.sleep(0.02)
        raise RuntimeError(f"the service is not ready after {PATIENCE:g} s: {word}")

    def kill(self) -> None:
        """End it as a power cut would, without any warning."""
        self.process.kill()
        self.process.wait()
        self._output.close()

    def stop(self) -> None:
        """End it as Ctrl-C does."""
        self.process.terminate()
        self.process.wait(PATIENCE)
        self._output.close()


@contextmanager
def serving(folder: Path | str, database: str, *options: str) -> Iterator[Service]:
    """Yield a service that runs for the length of a block."""
    service = Service(folder, database, *options)
    try:
        yield service
    finally:
        if service.process.poll() is None:
            service.stop()
