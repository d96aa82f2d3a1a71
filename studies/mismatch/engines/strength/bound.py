r"""How strong an effect stands in a recording: the Cramer-Rao bound, by numerical differences alone.

The residual of a recording is what dead reckoning misses (`residual`). With an effect of size p it changes by
J p. With noise of covariance C, and nuisances N that are estimated too, the bound is

    sigma^-2 = J' W (1 - P) W' J,   W W' = C^-1,   P = the projection on W' N

so that a change D = J p stands `|(1 - P) W' D| = p / sigma` standard deviations above the noise: its
strength. The same norm is used for changes that are not in proportion to p.

The noise is estimated from the residual itself: real odometry errors and pose errors are correlated in time.
W is diagonal in frequency (Whittle, Arkiv for Matematik 2, 1953): each column's Fourier coefficients are
divided by the root of its power spectrum, a running mean of the periodograms of all recordings. Columns are
taken as independent. Where there are a few poses only, at stops, the noise is taken as white.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from studies.mismatch.engines.strength.drive import TRUCKS, WHEELS, Drive
from studies.mismatch.engines.strength.residual import residual

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import NDArray

    Array = NDArray[np.float64]
    Residual = Mapping[str, Array]

STEP = 1e-4  # relative step of a calibration's number, small against the wavelength of any path
FEWEST = 15  # periodogram values in a mean; the spectrum then scatters by a quarter, a strength by an eighth
FEW = 40  # values in which no correlation can be seen


@dataclass(frozen=True, slots=True)
class Noise:
    """The noise of some recordings of one robot.

    Attributes:
        spectra: Frequency in cycles per value, and power spectrum, of each column of each part of the
            residual, both ascending.
    """

    spectra: Mapping[tuple[str, int], tuple[Array, Array]]

    @classmethod
    def of(cls, residuals: Sequence[Residual]) -> Noise:
        """Return the noise in the residuals of recordings."""
        parts = sorted(set().union(*residuals))
        return cls(
            {
                (part, column): _spectrum([each[part][:, column] for each in residuals if part in each])
                for part in parts
                for column in range(3)
            }
        )

    def whitened(self, changes: Sequence[Residual]) -> Array:
        """Return changes of residuals as one vector in units of the noise, W' D, shape `(K,)`."""
        return np.concatenate(
            [
                self._whitened(change[part][:, column], self.spectra[part, column])
                for change in changes
                for part in sorted(change)
                for column in range(3)
            ]
        )

    @staticmethod
    def _whitened(change: Array, spectrum: tuple[Array, Array]) -> Array:
        count, at = len(change), np.fft.rfftfreq(len(change))
        twice = np.where((at > 0.0) & (at < 0.5), 2.0, 1.0)  # rfft leaves out the negative frequencies
        scaled = np.fft.rfft(change) * np.sqrt(twice / (count * np.interp(at, *spectrum)))
        return np.concatenate((scaled.real, scaled.imag))


def _spectrum(series: Sequence[Array]) -> tuple[Array, Array]:
    if sum(map(len, series)) < FEW:
        return np.array([0.0]), np.array([np.mean(np.concatenate(series) ** 2)])
    frequency = np.concatenate([np.fft.rfftfreq(len(each)) for each in series])
    power = np.concatenate([np.abs(np.fft.rfft(each)) ** 2 / len(each) for each in series])
    order = np.argsort(frequency, kind="stable")
    width = min(FEWEST * len(series), len(order))
    sums = np.cumsum(np.concatenate(([0.0], power[order])))
    begin = np.clip(np.arange(len(order)) - width // 2, 0, len(order) - width)
    return frequency[order], (sums[begin + width] - sums[begin]) / width


@dataclass(frozen=True, slots=True)
class Ruler:
    """Measures how strong changes of some recordings are.

    Attributes:
        noise: Noise of the untouched recordings.
        untouched: Their residuals.
    """

    noise: Noise
    untouched: tuple[Residual, ...]

    @classmethod
    def of(cls, drives: Sequence[Drive]) -> Ruler:
        """Return the ruler of untouched recordings of one robot."""
        untouched = tuple(residual(drive) for drive in drives)
        return cls(Noise.of(untouched), untouched)

    def change(self, drives: Sequence[Drive]) -> Array:
        """Return the whitened change of the residuals in altered recordings, W' D, shape `(K,)`."""
        pairs = [(residual(drive), before) for drive, before in zip(drives, self.untouched, strict=True)]
        return self.noise.whitened(
            [{part: after[part] - before[part] for part in before} for after, before in pairs]
        )

    def nuisances(self, drives: Sequence[Drive], effect: str = "", component: str = "") -> list[Array]:
        """Return the changes `(K,)` by the numbers of a calibration, but for the one that an effect is."""
        trucks, own = drives[0].trucks, (effect, component)
        numbers: list[tuple[Callable[[Drive, int], Drive], int]]
        numbers = [(_wider, truck) for truck in range(trucks) if own != ("wheelbase", TRUCKS[truck])]
        numbers += [
            (_larger, wheel) for wheel in range(2 * trucks) if own != ("wheel_diameter", WHEELS[wheel])
        ]
        return [self.change([larger(drive, place) for drive in drives]) / STEP for larger, place in numbers]


def _wider(drive: Drive, truck: int) -> Drive:
    base = drive.wheelbase.copy()
    base[truck] *= 1.0 + STEP
    return replace(drive, wheelbase=base)


def _larger(drive: Drive, wheel: int) -> Drive:
    way = drive.way[:, wheel]
    return drive.with_way(wheel, way[0] + (1.0 + STEP) * (way - way[0]))


def left_of(change: Array, explained_by: Sequence[Array]) -> float:
    """Return the norm of what is left of a change `(K,)` when others `(K,)` have taken their best part."""
    others = [other / size for other in explained_by if (size := float(np.linalg.norm(other))) > 0.0]
    if not others:
        return float(np.linalg.norm(change))
    columns = np.stack(others, axis=1)
    share, *_ = np.linalg.lstsq(columns, change, rcond=1e-9)
    return float(np.linalg.norm(change - columns @ share))
