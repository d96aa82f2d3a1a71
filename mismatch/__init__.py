"""Where simulation and recording differ, which physics was left out, its model, and how sure that is."""

from omnimate.mismatch.diagnose import diagnose
from omnimate.mismatch.diagnosis import Diagnosis

__all__ = ["Diagnosis", "diagnose"]
