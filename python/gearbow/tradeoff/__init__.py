"""Accuracy and cost: settings of a run, compared with a verified reference."""

from gearbow.tradeoff.result import Recommendation, Tradeoff
from gearbow.tradeoff.settings import METHODS
from gearbow.tradeoff.trial import Skipped, Trial

__all__ = ["METHODS", "Recommendation", "Skipped", "Tradeoff", "Trial"]
