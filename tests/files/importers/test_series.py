"""A series refuses what is none."""

import numpy as np
import pytest

from omnimate.files.importers.errors import SourceError
from omnimate.files.importers.series import Series


@pytest.mark.parametrize(
    ("time", "value", "problem"),
    [
        ([0.0, 2.0, 1.0], [1.0, 2.0, 3.0], "sample 3: time goes backwards, from 2.0"),
        ([0.0, 1.0, 1.0], [1.0, 2.0, 3.0], "sample 3: time stands still"),
        ([0.0, np.nan, 1.0], [1.0, 2.0, 3.0], "sample 2: time nan"),
        ([-1.0, 0.0, 1.0], [1.0, 2.0, 3.0], "sample 1: time -1.0"),
        ([0.0, 1.0, 2.0], [np.nan] * 3, "no value in it"),
        ([], [], "no value in it"),
    ],
)
def test_bad_times_and_empty_series_are_refused_with_their_place(time, value, problem):
    with pytest.raises(SourceError, match=problem):
        Series(np.array(time, float), np.array(value, float), "counts", "left")
