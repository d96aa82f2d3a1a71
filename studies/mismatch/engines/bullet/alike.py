"""What a label says beside the effect: how strong it is, what looks like it, and what healthy robots show.

Changes are those of the true motion: the drive of the robot with the fault less that of its healthy twin,
both on a plane. They are measured in standard deviations of what floor and sensors add to the recording
(`proof.strength`), and compared with what each effect of the vocabulary would change.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from studies.mismatch.engines.strength.bound import left_of
from studies.mismatch.engines.strength.rivals import SEPARATE, rivals

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from studies.mismatch.engines.strength.bound import Ruler
    from studies.mismatch.engines.strength.drive import Drive

    Array = NDArray[np.float64]
    Name = tuple[str, str]

MOST = (
    0.5  # share of a change without a law that a name may leave; it then explains three quarters of its power
)
CLEAR = 5.0  # standard deviations below which a recording may not show something
# What contacts do to every robot: tyres creep, skid and scrub.
EVERYDAY = ("lateral_slip", "traction_slip", "turn_scrub", "wheelbase")


def alike(
    change: Array, effect: str, component: str, more: Mapping[str, Any], healthy: Drive, ruler: Ruler
) -> tuple[bool, list[dict[str, Any]]]:
    """Return whether an effect's law explains its change, and the effects that count as right in its place.

    A law that leaves more than half of the change does not explain it: the effect then is none of the
    vocabulary, whatever was built in. An effect whose law explains its change is matched by what explains it
    as well, up to 3 standard deviations; a change without a law by what explains most of it.

    Args:
        change: Whitened change `(K,)`.
        effect: The effect, or "unknown".
        component: Component on which it acts.
        more: Its parameters; of something unknown, the intervals in which it acts.
        healthy: What sensors see of the healthy twin.
        ruler: Its ruler.
    """
    moments = "slip_patch" if effect == "unknown" and more.get("intervals") else effect
    columns = rivals(moments, more, [healthy], ruler)
    leaves = {name: left_of(change, own) for name, own in columns.items()}
    half = MOST * float(np.linalg.norm(change))
    own = leaves.get((effect, component), np.inf)
    named = own <= max(half, SEPARATE)
    most = np.hypot(own, SEPARATE) if named else max(half, SEPARATE)
    return named, [
        {"effect": name, "component": place, "leaves": round(left, 2)}
        for (name, place), left in leaves.items()
        if left < most and (name, place) != (effect, component)
    ]


def everyday(healthy: Drive, ruler: Ruler, missed: Array) -> list[dict[str, Any]]:
    """Return what is true of the healthy robot beside any fault: naming it is right, missing it no mistake.

    Args:
        healthy: What sensors see of the healthy robot.
        ruler: Its ruler.
        missed: What dead reckoning misses of it, whitened, shape `(K,)`.
    """
    columns = {name: own for name, own in rivals("", {}, [healthy], ruler).items() if name[0] in EVERYDAY}
    whole = float(np.linalg.norm(missed))
    found = [
        {"effect": name, "component": place, "explains": round(explained, 2)}
        for (name, place), own in columns.items()
        if (explained := float(np.sqrt(max(0.0, whole**2 - left_of(missed, own) ** 2)))) > SEPARATE
    ]
    left = left_of(missed, [column for own in columns.values() for column in own])
    if left > CLEAR:
        places = sorted({place for _, place in columns})  # trucks and wheels
        found += [
            {"effect": name, "component": place, "explains": round(left, 2)}
            for place in places
            for name in ("unknown", "law")
        ]
    return found
