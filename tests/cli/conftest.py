"""Running the `omnimate` command in this process."""

from contextlib import contextmanager
from types import SimpleNamespace

import pytest

from docs.generate.conformance import BenchBus, Local, Simulated
from omnimate.cli.main import main
from omnimate.files.recordings.folder import save_recording
from omnimate.motion.paths import umbmark
from omnimate.vcan_sim.biases import linkage_biases
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth, with_errors
from tests.commands import runner

ROBOT = reference_vehicle()
NODES = sorted({owner.node for owner in (*ROBOT.encoders, *ROBOT.drives)})  # of the simulated devices


class ScriptedBus:
    """A bus on which prepared messages arrive, and then something else happens."""

    def __init__(self, messages, then):
        self.messages, self.then, self.closed = list(messages), then, False

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.closed = True

    def recv(self, _timeout):
        return self.messages.pop(0) if self.messages else self.then()


def device_of(bus, node):
    """Return the simulated device of a bench with a node id."""
    return next(device for device in bus._devices._devices if device.node == node)


def identity(device):
    return [device.objects[0x1018, sub] for sub in (1, 2, 3, 4)]


@pytest.fixture
def omnimate(capsys, monkeypatch):
    """Return a function that runs `omnimate` with arguments and gives its exit code and output."""
    return runner("omnimate", main, capsys, monkeypatch)


@pytest.fixture
def accepted(omnimate):
    """Return a function that runs `omnimate`, which must end with code 0, and gives its result."""

    def run(*arguments):
        result = omnimate(*arguments)
        assert result.code == 0, result.err
        return result

    return run


@pytest.fixture
def refused(omnimate):
    """Return a function that runs `omnimate`, which must fail without a traceback, and gives its stderr."""

    def run(*arguments, out=None):
        result = omnimate(*arguments)
        assert result.code == 1
        assert "Traceback" not in result.err
        assert out in {None, result.out}
        return result.err

    return run


@pytest.fixture
def said(refused):
    """Return a function that runs `omnimate` and gives the one error that it says, without repetition."""

    def run(*arguments):
        sentence = refused(*arguments).split("error: ", 1)[1]
        parts = sentence.strip().split("; ")
        assert len(parts) == len(set(parts))
        return sentence

    return run


@pytest.fixture(scope="session")
def small_drive(tmp_path_factory):
    """The recording folder of one square of 0.5 m each way; a test that changes it copies it."""
    robot = reference_vehicle()
    folder = tmp_path_factory.mktemp("small") / "drive"
    program = umbmark(0.5, 1, speed=0.4, link_length=robot.linkage.length)
    save_recording(simulate(robot, Truth(robot, seed=1), program, start_time=1.7e9), folder)
    return folder


@pytest.fixture(scope="session")
def erring_drive(tmp_path_factory):
    """The recording folder of squares of 4 m, of a robot whose trucks and linkage differ from its file."""
    robot = reference_vehicle()
    true = with_errors(robot, {"a": 336.17 / 340.0, "b": 340.0 / 336.17}, {"a": 1.00084, "b": 1.0 / 1.00084})
    folder = tmp_path_factory.mktemp("erring") / "recording"
    truth = Truth(true, effects=linkage_biases(0.01, -0.004, 0.002), seed=1)
    save_recording(simulate(robot, truth, umbmark(4.0, 2, link_length=1.0)), folder)
    return folder


@pytest.fixture
def on_bench(monkeypatch):
    """Return a function by which the verbs open a bus with these devices, on which some frames wait."""

    def use(kind, frames=()):
        bus = BenchBus(kind)
        bus._waiting.extend(frames)

        @contextmanager
        def opened(_url):
            yield bus

        monkeypatch.setattr("omnimate.driver.bus.bus.open_bus", opened)
        monkeypatch.setattr("omnimate.driver.canopen.node_access.open_bus", opened)
        passed = SimpleNamespace(monotonic=lambda: bus.time, time=lambda: bus.time)
        for module in (
            "canopen.node_access",
            "canopen.sdo",
            "conformance.probe",
            "scan.scan",
            "bus.clock",
        ):
            monkeypatch.setattr(f"omnimate.driver.{module}.time", passed)  # it passes on the bench alone
        return bus

    return use


@pytest.fixture
def simulated(on_bench):
    """Return the bench of the simulated devices, on which the verbs open a bus."""
    return on_bench(Simulated)


@pytest.fixture
def local_node(on_bench):
    """Return the bench of canopen's `LocalNode`, on which the verbs open a bus."""
    return on_bench(Local)
