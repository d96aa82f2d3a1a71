r"""How strong an effect stands in a recording: the Cramer-Rao bound, by numerical differences alone.

The residual of a recording is what dead reckoning misses between successive measured poses: forward, left
and yaw. With an effect of size p it changes by J p. With noise of covariance C, and nuisances N that are
estimated too, the bound is

    sigma^-2 = J' W (1 - P) W' J,   W W' = C^-1,   P = the projection on W' N

so that a change D = J p stands `|(1 - P) W' D| = p / sigma` standard deviations above the noise: its
strength. The same norm is used for changes that are not in proportion to p.

The noise is estimated from the residual itself, calibrated by least squares: real odometry errors and pose
errors are correlated in time. W is diagonal in frequency (Whittle, Arkiv for Matematik 2, 1953): each
channel's Fourier coefficients are divided by the root of its power spectrum, a running mean of the
periodograms of all recordings. Channels are taken as independent.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.proof.injections.drive import Drive, increments

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Array = NDArray[np.float64]

STEP = 1e-4  # relative step of a calibration's number, small against the wavelength of any path
FEWEST = 15  # periodogram values in a mean; the spectrum then scatters by a quarter, a strength by an eighth


def residual(drive: Drive) -> Array:
    """Return what dead reckoning misses between successive poses [m, m, rad], shape `(M - 1, 3)`."""
    path = drive.path
    reckoned = np.stack([np.interp(drive.pose_time, drive.time, axis) for axis in path.T], axis=1)
    return increments(reckoned) - increments(drive.pose)


@dataclass(frozen=True, slots=True)
class Noise:
    """The noise of some recordings of one robot.

    Attributes:
        spectra: Frequency in cycles per pose, and power spectrum, of each channel, both ascending.
    """

    spectra: tuple[tuple[Array, Array], ...]

    @classmethod
    def of(cls, residuals: Sequence[Array]) -> Noise:
        """Return the noise in residuals `(M - 1, 3)`, one for each recording."""
        return cls(tuple(_spectrum([each[:, channel] for each in residuals]) for channel in range(3)))

    def whitened(self, changes: Sequence[Array]) -> Array:
        """Return changes of residuals `(M - 1, 3)` as one vector in units of the noise, W' D."""
        return np.concatenate(
            [self._whitened(change[:, channel], channel) for change in changes for channel in range(3)]
        )

    def _whitened(self, change: Array, channel: int) -> Array:
        count = len(change)
        frequency, power = self.spectra[channel]
        at = np.fft.rfftfreq(count)
        twice = np.where((at > 0.0) & (at < 0.5), 2.0, 1.0)  # rfft leaves out the negative frequencies
        scaled = np.fft.rfft(change) * np.sqrt(twice / (count * np.interp(at, frequency, power)))
        return np.concatenate((scaled.real, scaled.imag))


def _spectrum(series: Sequence[Array]) -> tuple[Array, Array]:
    frequency = np.concatenate([np.fft.rfftfreq(len(each)) for each in series])
    power = np.concatenate([np.abs(np.fft.rfft(each)) ** 2 / len(each) for each in series])
    order = np.argsort(frequency, kind="stable")
    width = min(FEWEST * len(series), len(order))
    sums = np.cumsum(np.concatenate(([0.0], power[order])))
    index = np.arange(len(order))
    begin = np.clip(index - width // 2, 0, len(order) - width)
    return frequency[order], (sums[begin + width] - sums[begin]) / width


@dataclass(frozen=True, slots=True)
class Ruler:
    """Measures how strong changes of some recordings are.

    Attributes:
        noise: Noise of the untouched recordings.
        untouched: Their residuals.
        wheelbase: Whitened change by the wheelbase's relative size, shape `(K,)`.
        diameters: Likewise by each wheel's diameter, shape `(2, K)`.
    """

    noise: Noise
    untouched: tuple[Array, ...]
    wheelbase: Array
    diameters: Array

    @classmethod
    def of(cls, drives: Sequence[Drive]) -> Ruler:
        """Return the ruler of untouched recordings of one robot."""
        untouched = tuple(residual(drive) for drive in drives)
        noise = Noise.of(untouched)

        def slope(changed: Sequence[Drive]) -> Array:
            pairs = zip(changed, untouched, strict=True)
            return noise.whitened([(residual(drive) - before) / STEP for drive, before in pairs])

        wider = [replace(drive, wheelbase=drive.wheelbase * (1.0 + STEP)) for drive in drives]
        larger = [[_larger(drive, wheel) for drive in drives] for wheel in range(2)]
        return cls(noise, untouched, slope(wider), np.stack([slope(each) for each in larger]))

    def change(self, drives: Sequence[Drive]) -> Array:
        """Return the whitened change of the residuals in altered recordings, W' D, shape `(K,)`."""
        pairs = zip(drives, self.untouched, strict=True)
        return self.noise.whitened([residual(drive) - before for drive, before in pairs])

    def nuisances(self, effect: str, component: str) -> list[Array]:
        """Return the numbers of a calibration that are estimated beside an effect: those that it is not."""
        free = {"wheelbase": self.wheelbase, "a.left": self.diameters[0], "a.right": self.diameters[1]}
        free.pop({"wheelbase": "wheelbase", "wheel_diameter": component}.get(effect, ""), None)
        return list(free.values())


def _larger(drive: Drive, wheel: int) -> Drive:
    way = drive.way[:, wheel]
    return drive.with_way(wheel, way[0] + (1.0 + STEP) * (way - way[0]))


def left_of(change: Array, explained_by: Sequence[Array]) -> float:
    """Return the norm of what is left of a change `(K,)` when others `(K,)` have taken their best part."""
    if not explained_by:
        return float(np.linalg.norm(change))
    others = np.stack(explained_by, axis=1)
    sizes = np.linalg.norm(others, axis=0)
    others = others[:, sizes > 0.0] / sizes[sizes > 0.0]
    share, *_ = np.linalg.lstsq(others, change, rcond=1e-9)
    return float(np.linalg.norm(change - others @ share))
