"""What accuracy costs: settings of a run measured against a reference that is verified itself."""

from gearbow.tradeoff.result import Recommendation, Tradeoff
from gearbow.tradeoff.settings import METHODS
from gearbow.tradeoff.trial import Skipped, Trial

__all__ = ["METHODS", "Recommendation", "Skipped", "Tradeoff", "Trial"]
