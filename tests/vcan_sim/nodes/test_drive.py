"""CiA 402 drives: the power state machine, target velocity, ramps, and the watchdogs."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.vcan_sim.nodes.drive import PowerState, next_state, statusword
from omnimate.vcan_sim.reference import reference_vehicle

NODE, COUNTS = 11, 40_000  # of drive a.left; counts per turn
MASK = 0x6F
ENABLED, DISABLED, FAULT, QUICK_STOP = 0x27, 0x40, 0x08, 0x07


def enable(bench, node=NODE, mode=3, velocity=None):
    """Enable a drive as a master does, and let RPDO1 carry 60FFh."""
    bench.map_pdo(node, 0x1600, [0x60FF_0020], 0x200 + node)
    bench.write(node, 0x6060, 0, mode, 1)
    bench.nmt(0x01, node)
    for controlword in (0x06, 0x07, 0x0F):
        bench.write(node, 0x6040, 0, controlword, 2)
    bench.take()
    if velocity is not None:
        command(bench, velocity, node)


def command(bench, velocity, node=NODE):
    bench.frame(0x200 + node, velocity.to_bytes(4, "little", signed=True))


def state(bench, node=NODE):
    word = bench.read(node, 0x6041)
    return word & (0x4F if word & 0x08 or word & MASK & 0x40 else MASK)


def run(bench, syncs=100):
    """Let the ramps come to their end; return the speed of wheel a.left [rad/s]."""
    bench.sync(syncs)
    return bench.plant.speeds[0]


def test_a_drive_as_delivered_is_disabled_and_does_not_move(bench):
    assert state(bench) == DISABLED
    bench.write(NODE, 0x60FF, 0, COUNTS, 4)
    assert run(bench) == 0.0


def test_the_states_follow_shutdown_switch_on_and_enable(bench):
    for controlword, expected in [
        (0x06, 0x21),
        (0x07, 0x23),
        (0x0F, ENABLED),
        (0x07, 0x23),
        (0x00, DISABLED),
    ]:
        bench.write(NODE, 0x6040, 0, controlword, 2)
        assert state(bench) == expected


def test_a_target_velocity_by_rpdo_turns_the_wheel(bench):
    enable(bench, velocity=COUNTS)
    assert run(bench) == pytest.approx(2.0 * math.pi)
    assert bench.read(NODE, 0x606C) == COUNTS


def test_a_mirrored_motor_turns_its_wheel_forward_at_a_negative_velocity(bench):
    enable(bench, node=12, velocity=-COUNTS)
    bench.sync(100)
    assert bench.plant.speeds[1] == pytest.approx(2.0 * math.pi)


def test_without_a_mode_of_operation_it_does_not_move(bench):
    enable(bench, mode=0, velocity=COUNTS)
    assert run(bench) == 0.0


def test_modes_that_it_has_not_are_refused(bench):
    assert bench.aborts(NODE, 0x6060, 0, 1, 1) == 0x06090030
    assert bench.read(NODE, 0x6502) == (1 << 2 | 1 << 8)


def test_the_ramp_lets_a_vehicle_within_its_limits_follow_exactly(bench):
    limits = reference_vehicle().limits
    per_metre = COUNTS / (math.pi * 0.150)
    step = int(limits.acceleration * 0.015 * per_metre)
    enable(bench)
    for number in range(1, 30):
        command(bench, number * step)
        bench.sync()
        assert bench.plant.speeds[0] == pytest.approx(number * step / COUNTS * 2.0 * math.pi)


def test_a_jump_of_the_target_is_smoothed_by_the_profile_acceleration(bench):
    enable(bench)
    bench.write(NODE, 0x6083, 0, 10_000, 4)
    command(bench, COUNTS)
    speeds = []
    for _ in range(3):
        bench.sync()
        speeds.append(bench.plant.speeds[0] / (2.0 * math.pi) * COUNTS)
    assert speeds == pytest.approx([150.0, 300.0, 450.0])


def test_cyclic_synchronous_velocity_has_no_ramp(bench):
    enable(bench, mode=9, velocity=COUNTS)
    assert run(bench, 1) == pytest.approx(2.0 * math.pi)


def test_halt_stops_without_disabling(bench):
    enable(bench, velocity=COUNTS)
    run(bench)
    bench.write(NODE, 0x6040, 0, 0x010F, 2)
    assert run(bench) == 0.0
    assert state(bench) == ENABLED
    bench.write(NODE, 0x6040, 0, 0x000F, 2)
    assert run(bench) > 0.0


def test_a_quick_stop_ends_disabled(bench):
    enable(bench, velocity=COUNTS)
    run(bench)
    bench.write(NODE, 0x6040, 0, 0x0002, 2)
    assert state(bench) == QUICK_STOP
    assert run(bench) == 0.0
    assert state(bench) == DISABLED


def test_the_velocity_is_limited_by_607fh(bench):
    bench.write(NODE, 0x607F, 0, 1000, 4)
    enable(bench, velocity=-COUNTS)
    run(bench)
    assert bench.read(NODE, 0x606C) == 2**32 - 1000


def lose_commands(bench):
    bench.write(NODE, 0x1400, 5, 60, 2)  # [ms]
    command(bench, COUNTS)
    bench.sync(3)


def lose_the_heartbeat(bench):
    bench.write(NODE, 0x1016, 1, 0x7F_003C, 4)
    bench.frame(0x77F, b"\x05")
    bench.sync(3)


@pytest.mark.parametrize(("lose", "code"), [(lose_commands, 0x8250), (lose_the_heartbeat, 0x8130)])
@pytest.mark.parametrize(("option", "after"), [(0, ENABLED), (1, FAULT), (2, DISABLED), (3, DISABLED)])
def test_a_lost_master_is_reported_and_the_wheel_stops_as_6007h_says(bench, lose, code, option, after):
    bench.write(NODE, 0x6007, 0, option, 2)
    enable(bench, velocity=COUNTS)
    run(bench)
    lose(bench)
    assert state(bench) == ENABLED
    speed = run(bench)
    assert code.to_bytes(2, "little") in {data[:2] for data in bench.pdos(0x080 + NODE)}
    assert state(bench) == after
    assert (speed == 0.0) == (option != 0)


def test_a_refreshed_command_keeps_the_watchdog_quiet(bench):
    enable(bench)
    bench.write(NODE, 0x1400, 5, 60, 2)
    for _ in range(50):
        command(bench, COUNTS)
        bench.sync(3)  # 45 ms
    assert bench.plant.speeds[0] > 0.0
    assert bench.pdos(0x080 + NODE) == []


@pytest.mark.parametrize("nmt", [0x02, 0x80, 0x81, 0x82])
def test_a_drive_that_leaves_operational_stops(bench, nmt):
    enable(bench, velocity=COUNTS)
    run(bench)
    bench.nmt(nmt, NODE)
    assert run(bench) == 0.0
    bench.nmt(0x01, NODE)
    assert run(bench) == 0.0


def test_the_position_counts_what_the_motor_turned(bench):
    enable(bench, mode=9, velocity=1000)
    bench.sync(100)
    assert bench.read(NODE, 0x6064) == 1500


def test_the_status_is_sent_when_it_changes(bench):
    bench.nmt(0x01, NODE)
    bench.take()
    bench.write(NODE, 0x6040, 0, 0x06, 2)
    assert [data[0] & MASK for data in bench.pdos(0x180 + NODE)] == [0x21]
    bench.write(NODE, 0x6040, 0, 0x06, 2)
    assert bench.pdos(0x180 + NODE) == []


def test_a_drive_whose_encoder_is_a_channel_shows_it_at_6064h(make_bench):
    vehicle = reference_vehicle()
    left = replace(vehicle.encoders[0], node=NODE, profile="cia402")
    bench = make_bench(replace(vehicle, encoders=(left, *vehicle.encoders[1:])))
    bench.sync(count=-5)
    assert bench.read(NODE, 0x6064) == 2**32 - 5


states = st.sampled_from(PowerState)
controlwords = st.integers(0, 0xFFFF)
FAULTY = {PowerState.FAULT, PowerState.FAULT_REACTION_ACTIVE}


@given(states, controlwords, controlwords)
def test_without_voltage_no_drive_that_is_sound_stays_switched_on(state, controlword, previous):
    after = next_state(state, controlword & ~0x02, previous)
    assert after is PowerState.SWITCH_ON_DISABLED or state in FAULTY


@given(controlwords, controlwords)
def test_only_an_edge_of_fault_reset_leaves_the_fault(controlword, previous):
    left = next_state(PowerState.FAULT, controlword, previous) is not PowerState.FAULT
    assert left == bool(controlword & ~previous & 0x80)


@given(states, controlwords, controlwords)
def test_operation_is_enabled_by_enable_operation_alone_and_never_from_disabled(state, controlword, previous):
    if next_state(state, controlword, previous) is PowerState.OPERATION_ENABLED:
        assert controlword & 0x0F == 0x0F
        assert state is not PowerState.SWITCH_ON_DISABLED
        assert state not in FAULTY


@given(states, st.booleans(), st.booleans(), st.booleans())
def test_the_statusword_shows_the_state_and_the_bits(state, remote, reached, standing):
    word = statusword(state, remote=remote, target_reached=reached, standing=standing)
    shown = {mask: word & mask for mask in (0x4F, 0x6F)}
    free = state in {PowerState.SWITCH_ON_DISABLED, *FAULTY}  # the quick stop bit may have any value
    assert (shown[0x4F] == state & 0x4F) if free else (shown[0x6F] == state)
    assert (bool(word & 0x200), bool(word & 0x400), bool(word & 0x1000)) == (remote, reached, standing)


@pytest.mark.parametrize("state", [PowerState.OPERATION_ENABLED, PowerState.QUICK_STOP_ACTIVE])
def test_quick_stop_stops_a_drive_that_runs(state):
    assert next_state(state, 0x02, 0) is PowerState.QUICK_STOP_ACTIVE


@pytest.mark.parametrize("controlword", [0x07, 0x0F, 0x00, 0x02])
def test_from_switch_on_disabled_only_shutdown_leads_on(controlword):
    disabled = PowerState.SWITCH_ON_DISABLED
    assert next_state(disabled, controlword, 0) is disabled
