"""The command line ``gearbow``, also ``python -m gearbow``.

Each command calls one method of `gearbow.RotorSystem` and prints its result, as text or as JSON.
"""
