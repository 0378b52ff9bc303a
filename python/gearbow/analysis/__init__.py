"""Analyses that run variants of a system. They depend on a protocol, not on a class."""
