"""What residual bow does to a double-stage train: many runs, tables, figures and findings."""

from gearbow.study.case import Case, cases
from gearbow.study.runs import Results, run
from gearbow.study.settings import Settings

__all__ = ["Case", "Results", "Settings", "cases", "run"]
