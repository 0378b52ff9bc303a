"""Accuracy levels, and the error of a run estimated by more accurate runs."""
