import can
import pytest

from omnimate.driver.errors import BusError, NoSync
from omnimate.driver.robot import passive as module
from omnimate.driver.robot.passive import PassiveReader


class Quiet:
    """Host time that passes only while there is nothing to read."""

    def __init__(self):
        self.buses = []
        self.now = 0.0

    def monotonic(self):
        if not any(bus.queue for bus in self.buses):
            self.now += 0.4
        return self.now


@pytest.fixture
def replay(kit, monkeypatch):
    """Put frames on a bus that falls silent behind them."""
    host = Quiet()
    monkeypatch.setattr(module, "time", host)

    def put(frames):
        bus = kit.FakeBus()
        bus.queue.extend(frames)
        host.buses.append(bus)
        return bus

    return put


def cycle(kit, count, nodes=(1, 2)):
    return [kit.frame(0x080), *(kit.frame(0x180 + node, count.to_bytes(4, "little")) for node in nodes)]


def test_each_sync_opens_a_sample_and_the_last_one_is_kept(kit, replay):
    bus = replay([frame for count in (5, 6, 7) for frame in cycle(kit, count)])
    with PassiveReader(kit.one_truck(), bus) as reader:
        samples = list(reader.samples(idle=1.0))
    assert [sample.counts for sample in samples] == [(5, 5), (6, 6), (7, 7)]
    assert [sample.index for sample in samples] == [0, 1, 2]
    assert bus.sent == []
    assert reader.report().is_clean


def test_frames_of_the_other_master_are_known(kit, replay):
    talk = [
        kit.frame(0x000, b"\x01\0"),
        kit.frame(0x601, bytes(8)),
        kit.frame(0x581, bytes(8)),
        kit.frame(0x77F, b"\5"),
    ]
    bus = replay([*talk, *cycle(kit, 5)])
    reader = PassiveReader(kit.one_truck(), bus)
    list(reader.samples(idle=1.0))
    assert reader.report().unknown_frames == ()


def test_what_is_not_ours_is_counted_and_read_over(kit, replay):
    foreign = [kit.frame(0x3FF, b"\x01"), can.Message(arbitration_id=0x18FF1234)]
    reader = PassiveReader(kit.one_truck(), replay([*foreign, *cycle(kit, 5)]))
    assert len(list(reader.samples(idle=1.0))) == 1
    assert {key for key, _, _ in reader.report().unknown_frames} == {"3FFh", "18FF1234h"}


def test_a_boot_up_in_a_replay_rebases_the_wheel(kit, replay):
    frames = [
        *cycle(kit, 5000),
        kit.frame(0x701, b"\0"),
        kit.frame(0x000, b"\1\1"),
        *cycle(kit, 0, (1,)),
        kit.frame(0x182, b"\x88\x13\0\0"),
    ]
    samples = list(PassiveReader(kit.one_truck(), replay(frames)).samples(idle=1.0))
    assert samples[1].counts == (5000, 5000)


def test_a_bus_without_sync_and_without_a_pdo_of_the_vehicle_is_an_error(kit, replay):
    reader = PassiveReader(kit.one_truck(), replay([kit.frame(0x1FF, bytes(4))]))
    with pytest.raises(NoSync, match="no SYNC"):
        list(reader.samples(idle=1.0))


def test_the_first_sync_is_waited_for_until_the_end_at_most(kit, replay):
    reader = PassiveReader(kit.one_truck(), replay([]))
    reader.end_after(2.0)
    begin = module.time.now
    with pytest.raises(NoSync, match="within 2 s"):
        list(reader.samples())
    assert module.time.now - begin < 4.0


def test_a_bus_that_falls_silent_is_waited_for_until_the_end_at_most(kit, replay):
    pdos = [kit.frame(0x180 + node, bytes(4)) for _ in range(3) for node in (1, 2)]
    reader = PassiveReader(kit.one_truck(), replay(pdos))
    reader.end_after(4.0)
    begin = module.time.now
    assert len(list(reader.samples())) == 3
    assert module.time.now - begin < 10.0


def test_what_comes_before_anything_of_the_robot_is_counted_at_once_and_not_kept(kit, monkeypatch):
    bus = kit.FakeBus()
    bus.queue.extend([kit.frame(0x3FF)] * 1000)

    def recv(timeout=None):
        if not bus.queue:
            raise can.CanOperationError("unplugged")
        return bus.queue.popleft()

    monkeypatch.setattr(bus, "recv", recv)
    reader = PassiveReader(kit.one_truck(), bus)
    with pytest.raises(BusError):
        next(reader.samples())
    assert reader.report().unknown_frames == (("3FFh", "TPDO3 of node 127", 1000),)


def test_a_bus_that_fails_is_an_error(kit):
    bus = kit.FakeBus()
    bus.is_dead = True
    with pytest.raises(BusError, match="interface is down"):
        list(PassiveReader(kit.one_truck(), bus).samples(idle=1.0))
