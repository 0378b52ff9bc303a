"""Sensors: what measures a recorded motion."""
