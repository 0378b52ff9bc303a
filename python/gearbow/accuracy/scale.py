"""The unit of the errors of a signal: its variation, or a share of its mean."""

import numpy as np

from gearbow._core import SHARE_OF_MEAN
from gearbow._types import Array

#: The unit in the words of tables and figures.
UNIT = "RMS of the signal about its mean, at least 2 % of the mean"
#: A signal varies if its variation exceeds this fraction of its RMS: round-off varies less.
_VARIES = 1e-9


def unit_of_errors(values: Array) -> float:
    """Give the number by which the RMS of a difference is divided."""
    mean = float(np.linalg.norm(values.mean(axis=0)))
    return max(root_mean_square(values - values.mean(axis=0)), SHARE_OF_MEAN * mean)


def variation(values: Array) -> float:
    """Give the RMS of a signal about its mean; 0 if it is constant to round-off."""
    found = root_mean_square(values - values.mean(axis=0))
    return found if found > _VARIES * root_mean_square(values) else 0.0


def root_mean_square(values: Array) -> float:
    """Give the root mean square over time of the vector length."""
    return float(np.sqrt(np.mean(np.sum(values**2, axis=1))))
