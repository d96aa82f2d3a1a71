"""The screen: rows and events at 80 x 24, and what each key does."""

import asyncio
from dataclasses import replace
from pathlib import Path

import pytest
from textual.widgets import Static

from omnimate.cli.monitor.app import MonitorApp
from omnimate.cli.monitor.lines import Wanted


class Watch:
    """A watch that shows what the test gives it."""

    def __init__(self, snapshot, vehicle=None):
        self.snapshot = snapshot
        self.vehicle = vehicle
        self.targets = []

    def record(self, target):
        self.targets.append(target)


def on_screen(size=(80, 24), **options):
    """Run a test while the screen is on; it looks at it and presses keys."""

    def decorate(look):
        def run(snapshot, known):
            watch = Watch(snapshot)
            app = MonitorApp(watch, known, name="can0", bitrate=500_000, wanted=Wanted.of(""), **options)

            async def session():
                async with app.run_test(size=size) as pilot:
                    await pilot.pause()
                    await look(app, pilot, watch)

            asyncio.run(session())

        return run

    return decorate


def text(app, part):
    """The text of a part of the screen."""
    return str(app.query_one(part, Static).content)


@on_screen()
async def test_the_screen_shows_head_rows_robot_and_events(app, pilot, watch):
    assert "load 22-26 %" in text(app, "#head")
    assert len(text(app, "#rows").splitlines()) == 7
    assert "wheels [m/s]" in text(app, "#robot")
    assert "error frame" in text(app, "#events")


@pytest.mark.parametrize("size", [(80, 24), (40, 12), (200, 60)])
def test_it_draws_at_any_size(snapshot, known, size):
    @on_screen(size)
    async def draws(app, _pilot, _watch):
        assert max(map(len, text(app, "#rows").splitlines())) <= size[0]
        assert app.export_screenshot().startswith("<svg")

    draws(snapshot, known)


@on_screen()
async def test_space_stands_still_and_follows_again(app, pilot, watch):
    await pilot.press("space")
    watch.snapshot = replace(watch.snapshot, frames=9999)
    app.show()
    assert "PAUSED" in text(app, "#head")
    assert "1006 frames" in text(app, "#head")
    await pilot.press("space")
    assert "9999 frames" in text(app, "#head")


@on_screen()
async def test_slash_asks_for_a_filter_and_escape_leaves_it(app, pilot, watch):
    await pilot.press("slash", *"181", "enter")
    assert [line.split()[0] for line in text(app, "#rows").splitlines()] == ["id", "181"]
    assert "filter: 181" in text(app, "#head")
    await pilot.press("slash", *"x", "escape")
    assert "filter: 181" in text(app, "#head")


@on_screen()
async def test_s_sorts_by_rate_and_by_age(app, pilot, watch):
    await pilot.press("s")
    assert text(app, "#rows").splitlines()[-1].split()[0] in {"705", "18FF0001"}
    await pilot.press("s")
    assert text(app, "#rows").splitlines()[-1].split()[0] == "705"


@on_screen(target=Path("here"))
async def test_r_records_into_the_target_and_ends_it(app, pilot, watch):
    await pilot.press("r")
    watch.snapshot = replace(watch.snapshot, recording=None)
    await pilot.press("r")
    assert watch.targets == [None, Path("here")]  # the snapshot says that it records already


@on_screen()
async def test_a_recording_without_a_name_is_named_by_the_time(app, pilot, watch):
    watch.snapshot = replace(watch.snapshot, recording=None)
    await pilot.press("r")
    assert watch.targets[0].name.startswith("recording-")
    assert watch.targets[0].suffix == ".log"


@on_screen(size=(120, 24))
async def test_a_mapping_that_is_seen_gives_the_rows_their_names(app, pilot, watch):
    assert "TPDO1 of node 1" in text(app, "#rows")
    mapping = {(1, 0x1A00, 0): 1, (1, 0x1A00, 1): 0x60040020}
    watch.snapshot = replace(watch.snapshot, seen=mapping)
    app.show()
    assert "= 10000" in text(app, "#rows")
