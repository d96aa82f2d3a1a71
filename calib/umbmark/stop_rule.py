"""The rule of U section V on whether another calibration helps, as a sentence."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from omnimate.calib.umbmark.return_errors import ReturnErrors


def stop_rule(errors: ReturnErrors) -> str:
    """Return whether another pass helps, by U section V: E_max,syst against 3 SEM."""
    size = f"E_max,syst {_millimetres(errors.e_max_syst)}"
    helps = errors.second_pass_helps
    if helps is None:
        return f"{size}; SEM unknown with one run in each direction: drive five"
    limit = f"3 SEM = {_millimetres(3.0 * errors.sem)}"
    if helps:
        return f"{size} > {limit}: the systematic errors stand out, this pass will help"
    return f"{size} <= {limit}: the runs' scatter explains it, another pass is unlikely to help"


def _millimetres(length: float) -> str:
    return f"{1e3 * length:.1f} mm"
