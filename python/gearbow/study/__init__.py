"""Bow study: effect of residual bow on a double-stage train. Runs, tables, figures, findings."""

from gearbow.study.case import Case, cases
from gearbow.study.runs import Results, run
from gearbow.study.settings import Settings

__all__ = ["Case", "Results", "Settings", "cases", "run"]
