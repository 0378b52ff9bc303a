"""Recorded runs: plain data, access by name, energy, files and tables."""
