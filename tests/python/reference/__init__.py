"""Independent implementation of the equations in NumPy and SciPy. The tests compare gearbow with it.

The equations use nothing of gearbow. `bows`, `scenes` and `teeth` also describe each scene for gearbow. `records` and
`planted_faults` contain test data.
"""
