"""Odometry that a robot fleet trusts: CANopen encoders, UMBmark calibration and a simulated vehicle.

The names below are the public interface; `omnimate.api` documents them. Each is loaded when it is first used,
so that `import omnimate` costs next to nothing.

    import omnimate

    recording = omnimate.load_recording("lap1")
    print(omnimate.diagnose([recording]).says)
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from omnimate.api import (
        Calibrated,
        Diagnosis,
        Driver,
        Estimate,
        OmnimateError,
        Recording,
        VehicleParameters,
        calibrate,
        diagnose,
        load_recording,
        load_vehicle,
        open_driver,
        save_recording,
        save_vehicle,
        simulate,
        track,
    )

__version__ = "0.3.0"
__all__ = [
    "Calibrated",
    "Diagnosis",
    "Driver",
    "Estimate",
    "OmnimateError",
    "Recording",
    "VehicleParameters",
    "calibrate",
    "diagnose",
    "load_recording",
    "load_vehicle",
    "open_driver",
    "save_recording",
    "save_vehicle",
    "simulate",
    "track",
]


def __getattr__(name: str) -> object:
    """Return a name of the public interface, after loading what it needs.

    Raises:
        AttributeError: The name is not part of the public interface.
    """
    if name not in __all__:
        raise AttributeError(f"module 'omnimate' has no attribute {name!r}; it has {', '.join(__all__)}")
    return getattr(import_module("omnimate.api"), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
