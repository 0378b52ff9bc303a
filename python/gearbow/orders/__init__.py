"""Spectra of what was recorded, and the shaft and mesh orders in them."""

from gearbow.orders.fit import Orders
from gearbow.orders.kinematics import Kinematics, Order
from gearbow.orders.spectrum import Spectrum
from gearbow.orders.waterfall import Waterfall, waterfall

__all__ = ["Kinematics", "Order", "Orders", "Spectrum", "Waterfall", "waterfall"]
