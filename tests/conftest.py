"""What several rooms' tests need."""

import os
import sys
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from tests.samples import SHARED_DATA

# No test depends on the speed of the machine: the first example may have to compile what it calls.
# The examples of a test may share its fixtures, which they do not change.
# `make test-all` takes the profile `nightly`.
for profile, examples in (("project", 25), ("nightly", 100)):
    settings.register_profile(
        profile,
        max_examples=examples,
        deadline=None,
        suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
    )
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "project"))

# pytest-xdist tells its processes the size of the terminal, which the command line would then keep to.
for size in ("COLUMNS", "LINES"):
    os.environ.pop(size, None)

ROOT = Path(__file__).resolve().parents[1]


def pytest_addoption(parser):
    parser.addoption(
        "--touched-since",
        metavar="COMMIT",
        help="only tests of what differs from COMMIT",
    )


@pytest.hookimpl(optionalhook=True)  # `make mutation` loads no plugins
def pytest_xdist_auto_num_workers():
    """Return one process more than cores, as many tests wait for a browser or another process; at most 4."""
    return min((os.cpu_count() or 1) + 1, 4)


def pytest_collection_modifyitems(config, items):
    """Keep the tests that `--touched-since` asks for, and what can run without `../shared/data`."""
    commit = config.getoption("--touched-since")
    if commit is not None:
        sys.path.append(str(ROOT / ".ci"))
        from touched import touched_files  # noqa: PLC0415  # which CI alone asks for

        touched = {Path(name) for name in touched_files(ROOT, commit)}
        touched |= {folder for file in touched for folder in file.parents}
        keep(config, items, lambda item: touched.intersection(sources_of(item)))
    if not SHARED_DATA.is_dir():
        # One test of each file that needs the folder is skipped for all of them.
        first = {item.path: item for item in reversed(items) if "shared_data" in item.fixturenames}
        keep(config, items, lambda item: "shared_data" not in item.fixturenames or item is first[item.path])


def keep(config, items, is_kept):
    """Deselect all tests but those that are kept."""
    config.hook.pytest_deselected(items=[item for item in items if not is_kept(item)])
    items[:] = [item for item in items if is_kept(item)]


def sources_of(item):
    """Yield what a test is about: its own file, the module or folder that it mirrors, the page it runs."""
    path = item.path.relative_to(ROOT)
    mirrored = Path(*path.parts[1:-1], path.name.removeprefix("test_"))
    yield from (path, mirrored, mirrored.with_suffix(""))
    values = item.callspec.params.values() if hasattr(item, "callspec") else ()
    yield from (Path("docs", value) for value in values if isinstance(value, str) and value)


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The folder of real recordings beside the project; tests that need it are skipped without it."""
    if not SHARED_DATA.is_dir():
        pytest.skip("the real recordings (../shared/data) are not here")
    return SHARED_DATA


@pytest.fixture(scope="session")
def robot_toml() -> str:
    """The text of a whole two-truck robot's `vehicle.toml`."""
    head = """
name = "omnimate-7"
[truck.a]
wheelbase = 0.340
wheel_diameter_left = 0.150
wheel_diameter_right = 0.151
[truck.b]
wheelbase = 0.341
wheel_diameter_left = 0.150
wheel_diameter_right = 0.150
[linkage]
length = 1.000
[bus]
bitrate = 500000
sync_period = 0.015
"""
    units = ["counts_per_turn = 40000"] * 4 + ["counts_per_turn = 16384"] * 2 + ["counts_per_metre = 10000"]
    channels = ["a.left", "a.right", "b.left", "b.right", "joint_a", "joint_b", "link"]
    encoders = [
        f'[[encoder]]\nchannel = "{channel}"\nnode = {node}\ncob_id = {0x180 + node}\n'
        f"start_bit = 0\nbits = 32\nsigned = true\nsign = 1\n{unit}\n"
        for node, (channel, unit) in enumerate(zip(channels, units, strict=True), start=1)
    ]
    return head + "\n".join(encoders)
