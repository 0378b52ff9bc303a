"""Bow, unbalance, run-out and parameters from measured vibration, with their uncertainty."""

from gearbow.identification import unknown as unknown
