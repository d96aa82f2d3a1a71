"""Inputs with which parsers of files crash, hang or grow, searched for with coverage guidance.

Peer: the errors that each parser documents, all of them an `OmnimateError`; any other is a crash.

Usage: python -m studies.fuzz [--parser all] [--inputs 20000] [--longest 8192] [--seed 1] [--found fuzz-found]

Needs atheris (the extra `fuzz`), which mutates the seeds of a parser towards code that none has reached.
A hang is an input that takes more than a second of processor time. Memory is the growth of this process
from a tenth of the inputs on. Inputs that crash or hang are written into `--found`, one for each place in
the code.
Code that numba compiles is run, but not seen by the guidance.
"""

from __future__ import annotations

import importlib
import importlib.util
import io
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from studies.benchmark import options

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT / "tests" / "data"
LIBRARIES = ("omnimate", "canopen", "can", "tomllib", "configparser", "rosbags", "mcap")  # watched
MOST_TIME = 1.0  # [s] of processor time; inputs of 8 kB take tens of milliseconds
WARM = 0.1  # share of the inputs in which libraries and caches are filled
MEMORY_FILES = Path("/dev/shm")  # files in memory, where the system has them
FRAMES = 6  # of a log
RUN_SEED = b"""protocol = "umbmark"
side = 4.0
floor = "hall"
[[lap]]
direction = "cw"
start = 0
end = 1.5
"""


@dataclass(frozen=True)
class Parser:
    """A parser of a file, and files from which its search begins."""

    read: Callable[[Path], object]  # reads a file at a path; modules are imported when it is called
    seeds: Callable[[], Sequence[bytes]]  # returns contents that it accepts
    name: str = "input"  # of the file, whose suffix may decide on the format


def reader(module: str, name: str) -> Callable[[Path], object]:
    """Return a parser of the package that is imported when it is called."""

    def read(path: Path) -> object:
        parse: Callable[[Path], object] = getattr(importlib.import_module(f"omnimate.{module}"), name)
        return parse(path)

    return read


def eds(path: Path) -> object:
    from omnimate.driver.canopen.dcf import stated_values
    from omnimate.driver.canopen.eds import load_eds

    return stated_values(load_eds(path, 5).dictionary)


def zipped(path: Path) -> object:
    from omnimate.files.recordings.folder import log_path
    from omnimate.service.recording_zip import unpack

    with tempfile.TemporaryDirectory(dir=path.parent) as folder:
        return log_path(unpack(path.read_bytes(), Path(folder), limit=1_000_000))


def bag(path: Path) -> object:
    from omnimate.files.importers.rosbag.reader import messages_of, topics_of

    topics = [topic.name for topic in topics_of(path)]
    return [message.time for message in messages_of(path, topics)]


def log_seeds() -> list[bytes]:
    from omnimate.files.logs.frames import EXTENDED, REMOTE, Frame
    from omnimate.files.logs.writing import SUFFIXES, open_writer

    made = [Frame(0.01 * number, 0x181 + number, bytes(range(number + 2))) for number in range(FRAMES)]
    made += [Frame(0.1, 0x1ABCDE01, b"\1\2", EXTENDED), Frame(0.2, 0x705, b"", REMOTE, 1)]
    contents = [b"(1.0) can0 181#0011 R\n", b" (1.000000)  can0  181   [2]  00 11\n", b"1.0 can0 181 00 11\n"]
    with tempfile.TemporaryDirectory() as folder:
        for suffix in SUFFIXES:
            path = Path(folder) / f"log{suffix}"
            try:
                writer = open_writer(path, suffix)
            except ImportError:  # an extra that is not installed
                continue
            for frame in made:
                writer.write_frame(frame)
            writer.close()
            contents.append(path.read_bytes())
    trace = 'ASCII Trace IXXAT MiniMon V3\n"Time";"ID"\n"00:00:01.50";"123";"Std";"";"11 22"\n'
    return [*contents, trace.encode()]


def text_seeds(*names: str) -> Callable[[], list[bytes]]:
    return lambda: [(DATA / name).read_bytes() for name in names]


def vehicle_seeds() -> list[bytes]:
    from omnimate.files.importers.robots import single_truck
    from omnimate.vcan_sim.reference import reference_vehicle
    from omnimate.vehicle.file import format_vehicle
    from omnimate.vehicle.parameters import Truck

    robots = reference_vehicle(), single_truck("tried", Truck(0.5, 0.2, 0.201), 1000.0, 0.02)
    return [format_vehicle(robot).encode() for robot in robots]


def zip_seeds() -> list[bytes]:
    from omnimate.files.recordings.zipped import pack

    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "vehicle.toml").write_bytes(vehicle_seeds()[1])
        (Path(folder) / "can.log").write_bytes(log_seeds()[0])
        return [pack(Path(folder))]


def bag_seeds() -> list[bytes]:
    from rosbags import rosbag1
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    kind = "std_msgs/msg/Int32"
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "one.bag"
        with rosbag1.Writer(path) as writer:
            connection = writer.add_connection("/left", kind, typestore=store)
            for number in range(FRAMES):
                message = store.types[kind](data=number)
                writer.write(connection, 1000 * number, store.serialize_ros1(message, kind))
        return [path.read_bytes()]


def mcap_seeds() -> list[bytes]:
    from mcap.writer import Writer

    file = io.BytesIO()
    writer = Writer(file)
    writer.start("ros2", "omnimate")
    schema = writer.register_schema("std_msgs/msg/Int32", "ros2msg", b"int32 data")
    channel = writer.register_channel("/left", "cdr", schema)
    for number in range(FRAMES):
        writer.add_message(channel, number, bytes([0, 1, 0, 0, number, 0, 0, 0]), number)
    writer.finish()  # type: ignore[no-untyped-call]  # the library's
    return [file.getvalue()]


def dbc_seeds() -> list[bytes]:
    from omnimate.files.logs.dbc import dbc_of_vehicle
    from omnimate.vcan_sim.reference import reference_vehicle

    return [dbc_of_vehicle(reference_vehicle()).encode()]


def factsheet_seeds() -> list[bytes]:
    from omnimate.service.vda5050.factsheet import REQUIRED

    content = {"manufacturer": "maker", "serialNumber": "1"}
    parts = {part: dict.fromkeys(fields, 1.0) for part, fields in REQUIRED.items()}
    return [json.dumps(content | parts | {"agvGeometry": {"wheelDefinitions": [{"width": 0.1}]}}).encode()]


PARSERS = {
    "log": Parser(reader("files.logs.blocks", "read_log"), log_seeds),
    "eds": Parser(eds, text_seeds("eds/encoder.eds", "eds/drive.dcf"), "input.eds"),
    "vehicle": Parser(reader("vehicle.file", "load_vehicle"), vehicle_seeds),
    "run": Parser(reader("files.recordings.run_toml", "read_run"), lambda: [RUN_SEED]),
    "events": Parser(
        reader("files.recordings.events_jsonl", "read_events"),
        lambda: [b'{"time": 1.5, "node": 5, "what": "lost", "kind": "fault"}\n'],
    ),
    "poses": Parser(
        reader("files.recordings.poses_csv", "read_poses"),
        lambda: [b"t,body,x,y,theta,sigma_x,sigma_y,sigma_theta\n0.5,a,1.0,2.0,0.1,,,\n"],
    ),
    "factsheet": Parser(reader("service.vda5050.factsheet", "load_factsheet"), factsheet_seeds),
    "dbc": Parser(reader("files.logs.dbc", "read_dbc"), dbc_seeds),
    "zip": Parser(zipped, zip_seeds),
    "bag": Parser(bag, bag_seeds, "input.bag"),
    "mcap": Parser(bag, mcap_seeds, "input.mcap"),
}


def place_of(error: BaseException) -> str:
    """Return the type of an error and the innermost line of ours that it came through."""
    frames = traceback.extract_tb(error.__traceback__)
    ours = [
        frame for frame in frames if "site-packages" not in frame.filename and "/lib/" not in frame.filename
    ]
    last = (ours or list(frames))[-1]
    return f"{type(error).__name__} {Path(last.filename).name}:{last.lineno}"


def resident() -> float:
    """Return the memory of this process [MB]."""
    import psutil

    return float(psutil.Process().memory_info().rss) / 1e6


@dataclass
class Search:
    """Inputs that were tried on a parser."""

    parser: Parser
    path: Path
    inputs: int
    crashes: dict[str, bytes] = field(default_factory=dict)  # the first input of each place
    hangs: list[tuple[float, bytes]] = field(default_factory=list)  # processor time [s], input
    accepted: int = 0  # inputs that were read without an error
    count: int = 0
    memory: float = 0.0
    finished: Callable[[Search], None] = lambda _search: None

    def try_input(self, data: bytes) -> None:
        """Try an input, and note what is wrong."""
        from omnimate.vehicle.errors import OmnimateError

        self.path.write_bytes(data)
        began = time.process_time()
        try:
            self.parser.read(self.path)
            self.accepted += 1
        except OmnimateError:
            pass
        except Exception as error:  # noqa: BLE001  # each of these is a finding
            self.crashes.setdefault(place_of(error), data)
        taken = time.process_time() - began
        if taken > MOST_TIME:
            self.hangs.append((taken, data))
        self.count += 1
        if self.count == int(WARM * self.inputs):
            self.memory = resident()
        if self.count == self.inputs:
            self.finished(self)


def report(name: str, search: Search, seconds: float, folder: Path) -> str:
    """Write what was found; return a line of a table."""
    for number, (_, data) in enumerate(search.hangs):
        _keep(folder / f"{name}-hang-{number}", data)
    for place, data in search.crashes.items():
        _keep(folder / f"{name}-{re.sub(r'[^A-Za-z0-9_.]', '-', place)}", data)
    return (
        f"{name:10s} {search.count:9d} inputs, {search.accepted} read, {len(search.crashes)} crashes, "
        f"{len(search.hangs)} hangs, memory {resident() - search.memory:+.1f} MB, {seconds:.0f} s"
        + "".join(f"\n    {place}" for place in search.crashes)
    )


def _keep(path: Path, data: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)


def compiled_modules() -> list[str]:
    """Return the modules with functions for numba, which cannot compile what atheris has instrumented."""
    names = subprocess.run(
        ["git", "grep", "-l", "vehicle.compiled import", "--", "*.py"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    ).stdout.split()  # fmt: skip
    return [f"omnimate.{name.removesuffix('.py').replace('/', '.')}" for name in names]


def search(name: str, inputs: int, longest: int, seed: int, folder: Path) -> None:
    """Search with one parser, print what was found, and end this process."""
    import atheris

    parser = PARSERS[name]
    place = tempfile.mkdtemp(dir=MEMORY_FILES if MEMORY_FILES.is_dir() else None)
    path = Path(place) / parser.name
    began = time.monotonic()

    def finish(search: Search) -> None:
        print(report(name, search, time.monotonic() - began, folder), flush=True)
        shutil.rmtree(place)
        os._exit(bool(search.crashes or search.hangs))  # libFuzzer has no end from which it returns

    trial = Search(parser, path, inputs, finished=finish)
    corpus = Path(place) / "corpus"
    corpus.mkdir()
    with atheris.instrument_imports(include=list(LIBRARIES), exclude=compiled_modules()):
        for number, data in enumerate(parser.seeds()):
            (corpus / f"{number}").write_bytes(data)
            path.write_bytes(data)
            parser.read(path)
    flags = [f"-max_len={longest}", f"-seed={seed}", "-timeout=60", "-rss_limit_mb=4096", "-verbosity=0"]
    atheris.Setup([sys.argv[0], *flags, "-len_control=0", str(corpus)], trial.try_input)
    atheris.Fuzz()


def main() -> None:
    given = options(__doc__, parser="all", inputs=20_000, longest=8192, seed=1, found="fuzz-found")
    if importlib.util.find_spec("atheris") is None:
        sys.exit("atheris is missing: pip install -e '.[fuzz]'")
    if given.parser != "all":
        search(given.parser, given.inputs, given.longest, given.seed, Path(given.found))
    codes = [
        subprocess.call([sys.executable, "-m", "studies.fuzz", *sys.argv[1:], "--parser", name])
        for name in PARSERS
    ]
    sys.exit(any(codes))


if __name__ == "__main__":
    main()
