"""The report of a diagnosis: one self-contained HTML page, for the screen, the phone and paper."""
