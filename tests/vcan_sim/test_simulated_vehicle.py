"""The simulated vehicle: one step per SYNC, and all devices on one clock."""

from dataclasses import replace

import pytest

from omnimate.vcan_sim.reference import reference_single, reference_vehicle


def test_the_plant_moves_one_sync_period_per_sync(bench):
    bench.sync(3)
    assert bench.plant.steps == [0.015] * 3
    assert bench.plant.speeds == (0.0,) * 4
    assert bench.simulated.syncs == 3


def test_the_devices_clock_is_the_number_of_syncs_times_the_period(bench):
    bench.sync(200)
    assert bench.simulated.time == pytest.approx(3.0)
    assert bench.simulated.wait() is None


def test_two_vehicles_that_see_the_same_frames_send_the_same_frames(make_bench):
    def drive():
        bench = make_bench()
        bench.write(1, 0x1017, 0, 40, 2)
        bench.nmt(0x01)
        for number in range(100):
            bench.sync(count=number)
        return bench.take()

    assert drive() == drive()


def test_a_wheel_speed_hook_takes_the_drives_place(make_bench):
    bench = make_bench(wheel_speeds=lambda: (0.1 * bench.simulated.syncs, 0.0, 0.0, 0.0))
    bench.sync(2)
    assert bench.plant.speeds == (0.2, 0.0, 0.0, 0.0)


def test_a_vehicle_of_one_truck_has_two_wheels(make_bench):
    bench = make_bench(reference_single())
    bench.sync()
    assert bench.plant.speeds == (0.0, 0.0)
    assert sorted(bench.simulated.devices) == [1, 2, 11, 12]


def test_a_vehicle_without_drives_stands_still(make_bench):
    bench = make_bench(replace(reference_vehicle(), drives=()))
    bench.sync()
    assert bench.plant.speeds == (0.0,) * 4


def test_on_the_wall_clock_timers_run_without_sync(make_bench, monkeypatch):
    now = [100.0]
    monkeypatch.setattr("omnimate.vcan_sim.simulated_vehicle.time.monotonic", lambda: now[0])
    bench = make_bench(clock="wall")
    bench.write(1, 0x1017, 0, 50, 2)
    assert bench.simulated.wait() == pytest.approx(0.050)
    now[0] += 0.051
    bench.simulated.poll()
    assert bench.take() == [(0x701, b"\x7f")]
    assert bench.simulated.syncs == 0
