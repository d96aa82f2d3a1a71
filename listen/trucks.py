"""Assignment of four wheels to trucks and sides, order of the trucks, and the joints.

They are identified by the kinematics of the joints. With the yaw rates w and the speeds v of the trucks, the
joint angles A and B, and the length L of the linkage,

    dA/dt = w_A - (v_A sin A - v_B sin B) / L,    w = (v_right - v_left) / wheelbase,

and the same for B. For small angles the rate of a joint is therefore a linear function of the two wheels of
its truck, with opposite signs, and of speed times both joint angles. No other pair of wheels explains it. The
joint whose own angle has a negative factor is that of the truck in front. The sign of the other angle's
factor shows whether both joints count up in the same direction, and from that which wheels are on one side.
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

MIN_ODDS = 99.0  # [1] odds of a reported finding: an error rate of 1 %
PAIRINGS: tuple[tuple[Pair, Pair], ...] = (((0, 1), (2, 3)), ((0, 2), (1, 3)), ((0, 3), (1, 2)))
# Difference of the speeds of coupled trucks, relative: 1 - cos of a joint angle of 35 degrees is 0.18.
MAX_SPEED_DIFFERENCE = 0.2
# Share of the variance of a joint's rate that the linear kinematics do not explain: sin A is not A,
# resolution, delays. Assumption.
MODEL_RESIDUAL_SHARE = 0.005
MIN_HEADING_SHARE = 0.9  # share of the variance of a truck's heading explained by the other's (assumption)


class JointFit(NamedTuple):
    """Linear regression of the rate of a joint on a pair of wheels and on speed times angles.

    Attributes:
        residual_share: Share of its variance that is not explained [0 to 1]; 1 if the wheels' factors do not
            have opposite signs.
        wheel_factors: Its counts per count of each of the two wheels.
        angle_terms: For each movement that is no wheel, the factor of speed times its angle, and the natural
            logarithm of the odds of the regression with this term against that without it.
    """

    residual_share: float
    wheel_factors: tuple[float, float]
    angle_terms: tuple[tuple[float, float], ...]


class Trucks(NamedTuple):
    """Assignment of four wheels to trucks and sides.

    Attributes:
        pairing: Numbers of the two wheels of truck 0 and of truck 1; None if not identified.
        has_sides: Whether the sides are identified: the first wheels of both pairs are then on one side.
        front: Number of the truck in front, 0 or 1; None if not identified.
        joints: For each movement that is no wheel, the number of the truck whose joint it is; None if it is
            none.
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
        rates: Rates of the four wheels [counts/s], shape `(4, M)`.
        ratios: Counts of each wheel per count of the first one when driving straight, with signs, `(4,)`.
        nodes: Node that measures each wheel, `(4,)`; 0 if not known.
        others: Rate [counts/s] and value [counts] of each movement that is no wheel, each of shape `(M,)`.
        forward: +1 if the first wheel counts up when driving forward, -1 if down; 0 if not known.
    """
    scaled = rates / np.array(ratios)[:, None]
    speed = scaled.mean(axis=0)
    fits = [_fits(number, others, rates, ratios, speed) for number in range(len(others))]
    # Log likelihood of normal residuals: -n/2 times the logarithm of their variance.
    half_samples = 0.5 * effective_samples(rates.shape[1])
    scores = []
    for pairing in PAIRINGS:
        sums = [scaled[i] + scaled[j] for i, j in pairing]
        difference = float(np.mean((sums[0] - sums[1]) ** 2)) / 4
        allowed = MAX_SPEED_DIFFERENCE**2 * float(np.mean(speed**2))
        score = -half_samples * math.log(difference + allowed)
        score += sum(bool(nodes[i]) and nodes[i] == nodes[j] for i, j in pairing) * math.log(MIN_ODDS)
        for fit in fits:
            if min(entry.residual_share for entry in fit.values()) < 1.0 - MIN_EXPLAINED_SHARE:
                residual_share = min(fit[pair].residual_share for pair in pairing)
                score -= half_samples * math.log(residual_share + MODEL_RESIDUAL_SHARE)
        scores.append((score, pairing))
    scores.sort(reverse=True)
    evidence = scores[0][0] - scores[1][0]
    if evidence < math.log(MIN_ODDS):
        why = "which wheels belong to one truck is not identified: no joint turned with two of them"
        return Trucks(None, has_sides=False, front=None, joints=(None,) * len(others), reasons=(why,))
    pairing = scores[0][1]
    reasons = [f"trucks: odds e^{min(evidence, 999):.0f} for these pairs of wheels"]
    if any(nodes[i] and nodes[i] == nodes[j] for i, j in pairing):
        reasons.append("wheels that one device measures are assumed to be of one truck in 99 of 100 robots")
    joints = tuple(_truck_of(fit, pairing, half_samples) for fit in fits)
    reasons += [
        f"a joint of truck {truck + 1}: its wheels explain "
        f"{1 - fit[pairing[truck]].residual_share:.1%} of its rate"
        for fit, truck in zip(fits, joints, strict=True)
        if truck is not None
    ]
    front, front_reason = _front(fits, joints, pairing, forward)
    reasons.append(front_reason)
    pairing, has_sides, why = _sides(pairing, scaled, ratios, fits, joints)
    return Trucks(pairing, has_sides, front, joints, (*reasons, why))


def _fits(
    number: int, others: Sequence[tuple[Rates, Rates]], rates: Rates, ratios: Sequence[float], speed: Rates
) -> dict[Pair, JointFit]:
    """Return the regression of the rate of movement `number` for each pair of wheels."""
    rate = others[number][0]
    angles = [speed * (value - value.mean()) for _, value in others]
    constant = [speed, np.ones(len(rate))]  # because the zeros of the angles are not known
    fits: dict[Pair, JointFit] = {}
    for i, j in itertools.combinations(range(4), 2):
        residual_share, factors = fit_causes(rate, [rates[i], rates[j], *angles, *constant])
        is_turn = factors[0] * ratios[i] * factors[1] * ratios[j] < 0
        terms = []
        for k in range(len(angles)):
            without, _ = fit_causes(rate, [rates[i], rates[j], *angles[:k], *angles[k + 1 :], *constant])
            ratio = (without + MODEL_RESIDUAL_SHARE) / (residual_share + MODEL_RESIDUAL_SHARE)
            odds = 0.5 * effective_samples(len(rate)) * math.log(ratio)
            terms.append((float(factors[2 + k]), odds))
        wheel_factors = float(factors[0]), float(factors[1])
        fits[i, j] = JointFit(residual_share if is_turn else 1.0, wheel_factors, tuple(terms))
    return fits


def fit_causes(rate: Rates, causes: Sequence[Rates]) -> tuple[float, Rates]:
    """Return the share of a rate's variance that regression on causes leaves [0 to 1], and their factors."""
    table = np.vstack(causes).T
    scale = np.sqrt(np.mean(table**2, axis=0)) + 1e-300
    factors = np.linalg.lstsq(table / scale, rate, rcond=None)[0] / scale
    total = float(np.var(rate))
    return (float(np.var(rate - table @ factors)) / total if total else 1.0), factors


def _truck_of(fit: dict[Pair, JointFit], pairing: tuple[Pair, Pair], half_samples: float) -> int | None:
    """Return the truck whose joint a movement is; None if it is no joint, or may be that of either truck."""
    shares = [fit[pair].residual_share for pair in pairing]
    truck = int(shares[1] < shares[0])
    ratio = (shares[1 - truck] + MODEL_RESIDUAL_SHARE) / (shares[truck] + MODEL_RESIDUAL_SHARE)
    odds = half_samples * math.log(ratio)
    return truck if shares[truck] < 1.0 - MIN_EXPLAINED_SHARE and odds > math.log(MIN_ODDS) else None


def _front(
    fits: Sequence[dict[Pair, JointFit]],
    joints: Sequence[int | None],
    pairing: tuple[Pair, Pair],
    forward: int,
) -> tuple[int | None, str]:
    """Return the truck in front, by the sign of the factor of its joint's own angle, and the reason."""
    front_odds: dict[int, float] = {0: 0.0, 1: 0.0}
    for number, truck in enumerate(joints):
        if truck is not None and forward:
            factor, odds = fits[number][pairing[truck]].angle_terms[number]
            leads = truck if factor * forward < 0 else 1 - truck
            front_odds[leads] += odds
    front = int(front_odds[1] > front_odds[0])
    if front_odds[front] - front_odds[1 - front] < math.log(MIN_ODDS):
        return None, "which truck is in front is not identified"
    return front, f"truck {front + 1} is in front: driving forward straightens its joint"


def _sides(
    pairing: tuple[Pair, Pair],
    scaled: Rates,
    ratios: Sequence[float],
    fits: Sequence[dict[Pair, JointFit]],
    joints: Sequence[int | None],
) -> tuple[tuple[Pair, Pair], bool, str]:
    """Return the pairs in the order of sides, whether the sides are identified, and the reason."""
    alike, odds = _joints_alike(pairing, fits, joints)
    if odds > math.log(MIN_ODDS):
        first_wheels = [
            fits[joints.index(truck)][pair].wheel_factors[0] * ratios[pair[0]]
            for truck, pair in enumerate(pairing)
        ]
        is_same = ((first_wheels[0] > 0) == (first_wheels[1] > 0)) == (alike > 0)
        why = f"the kinematics of both joints identify the sides: odds e^{odds:.0f}"
        return _ordered(pairing, is_same=is_same), True, why
    one, other = (np.cumsum(scaled[i] - scaled[j]) for i, j in pairing)
    # The error of a ratio adds a heading in proportion to the travel, which regression removes.
    travel = [np.cumsum(scaled.mean(axis=0)), np.ones(len(one))]
    one, other = (heading - np.vstack(travel).T @ fit_causes(heading, travel)[1] for heading in (one, other))
    norm = math.sqrt(float(one @ one) * float(other @ other))
    correlation = float(one @ other) / norm if norm else 0.0
    if correlation**2 < MIN_HEADING_SHARE:
        return pairing, False, "which wheels of the two trucks are on one side is not identified"
    why = f"both trucks turn by the same angles, apart from their joints (correlation {abs(correlation):.3f})"
    return _ordered(pairing, is_same=correlation > 0), True, why


def _ordered(pairing: tuple[Pair, Pair], *, is_same: bool) -> tuple[Pair, Pair]:
    """Return the pairs, the second one reversed unless the first wheels of both are on one side."""
    return (pairing[0], pairing[1] if is_same else (pairing[1][1], pairing[1][0]))


def _joints_alike(
    pairing: tuple[Pair, Pair], fits: Sequence[dict[Pair, JointFit]], joints: Sequence[int | None]
) -> tuple[float, float]:
    """Return +1 if both joints count up in the same direction, else -1; and the log odds (natural).

    Both are 0 unless one joint of each truck is identified.
    """
    if joints.count(0) != 1 or joints.count(1) != 1:
        return 0.0, 0.0
    score = 0.0
    for truck in (0, 1):
        joint, other = joints.index(truck), joints.index(1 - truck)
        terms = fits[joint][pairing[truck]].angle_terms
        sign = -math.copysign(1.0, terms[joint][0] * terms[other][0])
        score += sign * min(terms[joint][1], terms[other][1])
    return math.copysign(1.0, score), abs(score)
