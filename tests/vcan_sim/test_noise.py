"""Random numbers by place."""

import numpy as np

from omnimate.vcan_sim.noise import normal_pair


def stream(seed, number, count=20_000):
    return np.array([normal_pair(seed, number, index) for index in range(count)])


def test_a_deviate_depends_on_seed_stream_and_place_alone():
    assert normal_pair(3, 1, 17) == normal_pair(3, 1, 17)
    assert (
        len({normal_pair(3, 1, 17), normal_pair(4, 1, 17), normal_pair(3, 2, 17), normal_pair(3, 1, 18)}) == 4
    )


def test_deviates_are_standard_normal():
    values = stream(0, 0).ravel()
    assert abs(values.mean()) < 4.0 / np.sqrt(len(values))
    assert abs(values.var() - 1.0) < 4.0 * np.sqrt(2.0 / len(values))
    assert abs((values**4).mean() - 3.0) < 4.0 * np.sqrt(96.0 / len(values))


def test_pairs_neighbours_streams_and_seeds_are_uncorrelated():
    first, other, foreign = stream(0, 0), stream(0, 1), stream(1, 0)
    pairs = [(first[:, 0], first[:, 1]), (first[1:, 0], first[:-1, 0]), (first, other), (first, foreign)]
    for first, second in pairs:
        assert abs(np.corrcoef(first.ravel(), second.ravel())[0, 1]) < 4.0 / np.sqrt(first.size)
