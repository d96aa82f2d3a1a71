"""A small robot's log: two wheels on a SYNC bus, with heartbeats, a status word and a temperature."""

import numpy as np
import pytest

from omnimate.files.logs.frames import Frame, frames_of
from omnimate.listen.learning import learn_bus

PERIOD = 0.02


def in_order(rows):
    """Return frames as a log, in the order of their times."""
    return frames_of(sorted(rows, key=lambda row: row.time))


def wheel_angles(seconds=40.0):
    """Return the times of SYNC and the angles of both wheels: straight on, turns both ways, a stop."""
    time = np.arange(0.0, seconds, PERIOD)
    speed = np.where(time < seconds - 5, 6.0, 0.0)
    turn = np.where((time > 12) & (time < 16), 2.0, 0.0) - np.where((time > 24) & (time < 27), 2.5, 0.0)
    window = np.hanning(25) / np.hanning(25).sum()
    speed, turn = (np.convolve(each, window, "same") for each in (speed, turn))
    return time, np.cumsum(speed - turn) * PERIOD, np.cumsum(speed + turn) * PERIOD


def robot_log(counts_per_turn=20000, start=2**32 - 3000, extra=()):
    random = np.random.default_rng(1)
    time, left, right = wheel_angles()
    scale = counts_per_turn / (2 * np.pi)
    rows = [Frame(float(t), 0x80, b"") for t in time]
    for node, angle, sign in ((5, left, -1), (6, right, 1)):
        counts = np.floor(sign * scale * angle).astype(np.int64) + start
        speed = np.rint(sign * np.gradient(angle, time) * 100 + random.normal(0, 0.5, len(time))).astype(int)
        for t, count, rate in zip(time.tolist(), counts.tolist(), speed.tolist(), strict=True):
            data = (count % 2**32).to_bytes(4, "little") + rate.to_bytes(2, "little", signed=True)
            rows.append(Frame(t + 0.0004 + 0.0002 * (node - 5), 0x180 + node, data))
        rows += [Frame(t + 0.3, 0x700 + node, b"\x05") for t in range(39)]
    status = np.where(time < 2, 0x0231, np.where(time < 2.2, 0x0233, 0x0237))
    status = status | np.where(np.floor(time / 3) % 2 > 0, 0x0400, 0)
    warm = np.rint(250 + 10 * np.sin(time / 9) + random.normal(0, 0.6, len(time))).astype(int)
    for t, word, heat in zip(time[::5].tolist(), status[::5].tolist(), warm[::5].tolist(), strict=True):
        rows.append(
            Frame(t + 0.009, 0x286, int(word).to_bytes(2, "little") + int(heat).to_bytes(2, "little"))
        )
    return in_order(row._replace(time=row.time + 1000.0) for row in (*rows, *extra))


@pytest.fixture(scope="session")
def robot_findings():
    return learn_bus(robot_log())
