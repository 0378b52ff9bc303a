"""Quantities with units: the unit of every field, and conversion to SI units."""
