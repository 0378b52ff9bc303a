"""Accuracy and cost: settings of a run, compared with a verified reference."""

from gearbow.studies.result import Recommendation, Skipped, Tradeoff, Trial
from gearbow.studies.settings import METHODS

__all__ = ["METHODS", "Recommendation", "Skipped", "Tradeoff", "Trial"]
