"""Spectra of recorded signals, and amplitudes at the orders of shafts and meshes."""

from gearbow.description.layout import Kinematics, Order
from gearbow.orders.fit import Orders
from gearbow.orders.spectrum import Spectrum, Waterfall, waterfall

__all__ = ["Kinematics", "Order", "Orders", "Spectrum", "Waterfall", "waterfall"]
