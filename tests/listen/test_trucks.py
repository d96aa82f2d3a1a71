"""Two trucks on a linkage: which wheels belong together, which truck is in front, and the joints."""

import math

import numpy as np
import pytest

from omnimate.listen.shafts import CLOCK_STEP
from omnimate.listen.trucks import find_trucks

LENGTH, BASE = 1.1, 0.4


def drive(seed, seconds=60.0):
    """Return the rates of a.left, a.right, b.left and b.right, and the angles of both joints."""
    random = np.random.default_rng(seed)
    count = int(seconds / CLOCK_STEP)
    window = np.hanning(30) / np.hanning(30).sum()
    speed = np.convolve(np.repeat(random.uniform(0.15, 0.5, count // 100 + 1), 100)[:count], window, "same")
    turn = np.convolve(np.repeat(random.uniform(-0.4, 0.4, count // 75 + 1), 75)[:count], window, "same")
    sway = np.convolve(np.repeat(random.uniform(-0.2, 0.2, count // 60 + 1), 60)[:count], window, "same")
    rates, angles = np.zeros((4, count)), np.zeros((2, count))
    a = b = 0.0
    for n in range(count):
        v_a, w_a = speed[n], turn[n] - 0.5 * a
        v_b = v_a * math.cos(a) / math.cos(b)
        w_b = -1.2 * b + sway[n]
        link = (v_a * math.sin(a) - v_b * math.sin(b)) / LENGTH
        a, b = a + (w_a - link) * CLOCK_STEP, b + (w_b - link) * CLOCK_STEP
        half = BASE / 2
        rates[:, n] = v_a - w_a * half, v_a + w_a * half, v_b - w_b * half, v_b + w_b * half
        angles[:, n] = a, b
    return rates, angles


def found(seed, order=(0, 1, 2, 3), joint_signs=(1, 1), nodes=(0, 0, 0, 0), ratios=(1, 1, 1, 1), forward=1):
    rates, angles = drive(seed)
    rates = (rates * 8000.0)[list(order)] * np.array(ratios)[:, None]
    counts = angles * np.array(joint_signs)[:, None] * 3000.0
    others = [(np.gradient(each, CLOCK_STEP), each + 700.0) for each in counts]
    return find_trucks(rates, ratios, nodes, others, forward)


@pytest.mark.parametrize("seed", range(4))
def test_the_kinematics_of_the_joints_identify_trucks_sides_and_which_is_in_front(seed):
    trucks = found(seed)
    assert trucks.pairing == ((0, 1), (2, 3))
    assert trucks.joints == (0, 1)
    assert trucks.front == 0
    assert trucks.has_sides


@pytest.mark.parametrize("signs", [(1, 1), (1, -1), (-1, 1), (-1, -1)])
def test_neither_the_order_of_the_wheels_nor_the_direction_of_a_joint_changes_the_answer(signs):
    trucks = found(1, order=(3, 0, 2, 1), joint_signs=signs)  # b.right, a.left, b.left, a.right
    assert trucks.pairing == ((0, 2), (3, 1))
    assert trucks.joints == (1, 0)
    assert trucks.front == 1
    assert trucks.has_sides


def test_mirrored_wheels_are_paired_all_the_same_and_driving_backwards_is_known_by_the_sign():
    trucks = found(2, ratios=(1, -1, 1, -1), forward=1)
    assert (trucks.pairing, trucks.front) == (((0, 1), (2, 3)), 0)
    assert found(2, forward=0).front is None


def test_trucks_that_turn_alike_are_distinguished_only_by_what_one_device_measures():
    rates = drive(3)[0][[0, 1, 0, 1]]
    assert find_trucks(rates, (1, 1, 1, 1), (0, 0, 0, 0), (), 1).pairing is None
    assert find_trucks(rates, (1, 1, 1, 1), (5, 5, 7, 7), (), 1).pairing == ((0, 1), (2, 3))
