"""The report of a diagnosis: one self-contained HTML page, for the screen, the phone and paper."""

from omnimate.mismatch.report.page import render

__all__ = ["render"]
