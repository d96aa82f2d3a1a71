"""Assignment of four wheels to trucks and sides, order of the trucks, and the joints.

The law of a joint identifies them: with the truck's rate of turn w, its speed v, the joint angles A and B
of both trucks and the length L of the linkage, its angle changes by

    dA/dt = w_A - (v_A sin A - v_B sin B) / L,    w = (v_right - v_left) / wheelbase,

and the same for B. So its rate is a linear function of the two wheels of its truck, with opposite signs, and
of speed times joint angles, in whatever counts; the wheels of no other pair explain it. The truck whose own
term has the negative sign is in front; the sign of the other term shows whether both joints count up in the
same direction, and so which wheels are on one side.
"""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from omnimate.listen.shafts import MIN_EXPLAINED_SHARE, effective_samples

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Rates = NDArray[np.float64]
    Pair = tuple[int, int]

MIN_ODDS = 99.0  # [1] for an error rate of 1 %
PAIRINGS: tuple[tuple[Pair, Pair], ...] = (((0, 1), (2, 3)), ((0, 2), (1, 3)), ((0, 3), (1, 2)))
MAX_SPEED_DIFFERENCE = 0.2  # relative, of coupled trucks: at 35 degrees to the linkage, cos is 0.82
LAW_RESIDUAL = 0.005  # of a joint's rate beyond the law: sin A for A, resolution, delays (assumption)
MIN_HEADING_SHARE = 0.9  # of a truck's turning explained by the other's (assumption)


class JointFit(NamedTuple):
    """The law of a joint, fitted with two wheels.

    Attributes:
        left: Share of the variance of its rate that is left [0 to 1]; 1 where the signs are not opposite.
        factors: Its counts for each count of the two wheels.
        angles: For each of the other movements the factor of speed times its angle, and the logarithm of the
            odds that its sign is this.
    """

    left: float
    factors: tuple[float, float]
    angles: tuple[tuple[float, float], ...]


class Trucks(NamedTuple):
    """Assignment of four wheels to trucks and sides.

    Attributes:
        pairing: The wheels of one truck and those of the other; None for `cannot tell`.
        has_sides: Whether the first wheels of both pairs are on one side, and the second ones.
        front: Number of the truck in front; None for `cannot tell`.
        joints: For each of the other movements the number of the truck whose joint it is; None for others.
        reasons: Sentences on how it was decided.
    """

    pairing: tuple[Pair, Pair] | None
    has_sides: bool
    front: int | None
    joints: tuple[int | None, ...]
    reasons: tuple[str, ...]


def find_trucks(
    rates: Rates,
    ratios: Sequence[float],
    nodes: Sequence[int],
    others: Sequence[tuple[Rates, Rates]],
    forward: int,
) -> Trucks:
    """Return the assignment of wheels to trucks and sides.

    Args:
        rates: Rates of the four wheels in their counts, shape `(4, M)`.
        ratios: Their ratios as far as they are known, with signs.
        nodes: Nodes that measure them; 0 where that is not known.
        others: Rate and value of each other movement, each of shape `(M,)`.
        forward: +1 or -1, whether the first wheel counts up when driving forward; 0 where that is not known.
    """
    normal = rates / np.array(ratios)[:, None]
    speed = normal.mean(axis=0)
    fits = [_fits(number, others, rates, ratios, speed) for number in range(len(others))]
    worth = 0.5 * effective_samples(rates.shape[1])
    scores = []
    for pairing in PAIRINGS:
        sums = [normal[i] + normal[j] for i, j in pairing]
        apart = float(np.mean((sums[0] - sums[1]) ** 2)) / 4 + MAX_SPEED_DIFFERENCE**2 * float(
            np.mean(speed**2)
        )
        score = -worth * math.log(apart)
        score += sum(bool(nodes[i]) and nodes[i] == nodes[j] for i, j in pairing) * math.log(MIN_ODDS)
        for fit in fits:
            if min(each.left for each in fit.values()) < 1.0 - MIN_EXPLAINED_SHARE:
                score -= worth * math.log(min(fit[pair].left for pair in pairing) + LAW_RESIDUAL)
        scores.append((score, pairing))
    scores.sort(reverse=True)
    evidence = scores[0][0] - scores[1][0]
    nothing: tuple[int | None, ...] = (None,) * len(others)
    if evidence < math.log(MIN_ODDS):
        why = "which wheels belong to one truck is not identified: no joint turned with two of them"
        return Trucks(None, has_sides=False, front=None, joints=nothing, reasons=(why,))
    pairing = scores[0][1]
    reasons = [f"trucks: odds e^{min(evidence, 999):.0f} for these pairs of wheels"]
    if any(nodes[i] and nodes[i] == nodes[j] for i, j in pairing):
        reasons.append("wheels that one device measures are of one truck, in 99 of 100 robots")
    joints = tuple(_truck_of(fit, pairing, worth) for fit in fits)
    reasons += [
        f"a joint of truck {truck + 1}: its wheels explain {1 - fit[pairing[truck]].left:.1%} of its rate"
        for fit, truck in zip(fits, joints, strict=True)
        if truck is not None
    ]
    front, said = _front(fits, joints, pairing, forward)
    reasons += said
    pairing, has_sides, why = _sides(pairing, normal, ratios, fits, joints)
    return Trucks(pairing, has_sides, front, joints, (*reasons, why))


def _fits(
    number: int, others: Sequence[tuple[Rates, Rates]], rates: Rates, ratios: Sequence[float], speed: Rates
) -> dict[Pair, JointFit]:
    """Return the law of a joint, fitted with each pair of wheels."""
    rate = others[number][0]
    angles = [speed * (value - value.mean()) for _, value in others]
    constant = [speed, np.ones(len(rate))]  # the angles' zeros are not known
    fits: dict[Pair, JointFit] = {}
    for i, j in itertools.combinations(range(4), 2):
        left, factors = _fit(rate, [rates[i], rates[j], *angles, *constant])
        is_turn = factors[0] * ratios[i] * factors[1] * ratios[j] < 0
        terms = []
        for k in range(len(angles)):
            without, _ = _fit(rate, [rates[i], rates[j], *angles[:k], *angles[k + 1 :], *constant])
            odds = (
                0.5
                * effective_samples(len(rate))
                * math.log((without + LAW_RESIDUAL) / (left + LAW_RESIDUAL))
            )
            terms.append((float(factors[2 + k]), odds))
        turns = float(factors[0]), float(factors[1])
        fits[i, j] = JointFit(left if is_turn else 1.0, turns, tuple(terms))
    return fits


def _fit(rate: Rates, causes: Sequence[Rates]) -> tuple[float, Rates]:
    """Return the share of a rate's variance that causes leave, and their factors."""
    table = np.vstack(causes).T
    scale = np.sqrt(np.mean(table**2, axis=0)) + 1e-300
    factors = np.linalg.lstsq(table / scale, rate, rcond=None)[0] / scale
    whole = float(np.var(rate))
    return (float(np.var(rate - table @ factors)) / whole if whole else 1.0), factors


def _truck_of(fit: dict[Pair, JointFit], pairing: tuple[Pair, Pair], worth: float) -> int | None:
    """Return the truck whose joint a movement is, None where it is none or may be of both."""
    left = [fit[pair].left for pair in pairing]
    truck = int(left[1] < left[0])
    odds = worth * math.log((left[1 - truck] + LAW_RESIDUAL) / (left[truck] + LAW_RESIDUAL))
    return truck if left[truck] < 1.0 - MIN_EXPLAINED_SHARE and odds > math.log(MIN_ODDS) else None


def _front(
    fits: Sequence[dict[Pair, JointFit]],
    joints: Sequence[int | None],
    pairing: tuple[Pair, Pair],
    forward: int,
) -> tuple[int | None, list[str]]:
    """Return the truck in front, by the sign of its joint's own term, and why."""
    front_odds: dict[int, float] = {0: 0.0, 1: 0.0}
    for number, truck in enumerate(joints):
        if truck is not None and forward:
            factor, odds = fits[number][pairing[truck]].angles[number]
            leads = truck if factor * forward < 0 else 1 - truck
            front_odds[leads] += odds
    front = int(front_odds[1] > front_odds[0])
    if front_odds[front] - front_odds[1 - front] < math.log(MIN_ODDS):
        return None, ["which truck is in front is not identified"]
    return front, [f"truck {front + 1} is in front: driving straightens its joint"]


def _sides(
    pairing: tuple[Pair, Pair],
    normal: Rates,
    ratios: Sequence[float],
    fits: Sequence[dict[Pair, JointFit]],
    joints: Sequence[int | None],
) -> tuple[tuple[Pair, Pair], bool, str]:
    """Return the pairs with wheels of one side in one place, whether that is known, and why."""
    alike, odds = _joints_alike(pairing, fits, joints)
    if odds > math.log(MIN_ODDS):
        turned = [
            fits[joints.index(truck)][pair].factors[0] * ratios[pair[0]] for truck, pair in enumerate(pairing)
        ]
        is_same = ((turned[0] > 0) == (turned[1] > 0)) == (alike > 0)
        return (
            _placed(pairing, is_same=is_same),
            True,
            f"the law of both joints identifies the sides: odds e^{odds:.0f}",
        )
    one, other = (np.cumsum(normal[i] - normal[j]) for i, j in pairing)
    # A wrong ratio adds to a heading what was driven; that is taken away from both.
    driven = [np.cumsum(normal.mean(axis=0)), np.ones(len(one))]
    one, other = (each - np.vstack(driven).T @ _fit(each, driven)[1] for each in (one, other))
    whole = math.sqrt(float(one @ one) * float(other @ other))
    together = float(one @ other) / whole if whole else 0.0
    if together**2 < MIN_HEADING_SHARE:
        return pairing, False, "which wheels of the two trucks are on one side is not identified"
    why = f"both trucks turn by the same angles, apart from their joints (correlation {abs(together):.3f})"
    return _placed(pairing, is_same=together > 0), True, why


def _placed(pairing: tuple[Pair, Pair], *, is_same: bool) -> tuple[Pair, Pair]:
    return (pairing[0], pairing[1] if is_same else (pairing[1][1], pairing[1][0]))


def _joints_alike(
    pairing: tuple[Pair, Pair], fits: Sequence[dict[Pair, JointFit]], joints: Sequence[int | None]
) -> tuple[float, float]:
    """Return whether both joints count up in the same direction (+1, -1), and the logarithm of the odds."""
    if joints.count(0) != 1 or joints.count(1) != 1:
        return 0.0, 0.0
    both = 0.0
    for truck in (0, 1):
        joint, other = joints.index(truck), joints.index(1 - truck)
        angles = fits[joint][pairing[truck]].angles
        sign = -math.copysign(1.0, angles[joint][0] * angles[other][0])
        both += sign * min(angles[joint][1], angles[other][1])
    return math.copysign(1.0, both), abs(both)
