"""The unit of the errors of a signal: its variation, or a share of its mean."""

import numpy as np

from gearbow._types import Array

__all__ = ["SHARE_OF_MEAN", "UNIT", "root_mean_square", "unit_of_errors", "variation"]

#: Smallest unit of an error, as a share of the mean of the signal; the core has the same value. The
#: tolerance of a run refers to the whole motion. In 200 random trains, "engineering" with its
#: tolerance of 1e-4 leaves errors of up to 1.2e-4 of the mean mesh force, however little the force
#: varies; the promised 1e-2 of this share is 2e-4.
SHARE_OF_MEAN = 0.02
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
