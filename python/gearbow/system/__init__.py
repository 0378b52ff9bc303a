"""The rotor system: description, linear analyses and time integration."""

from gearbow.system.rotor_system import RotorSystem

__all__ = ["RotorSystem"]
