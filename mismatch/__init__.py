"""Where simulation and recording differ, which physics was left out, its model, and how sure that is."""

from mismatch.diagnose import diagnose
from mismatch.diagnosis import Diagnosis

__all__ = ["Diagnosis", "diagnose"]
