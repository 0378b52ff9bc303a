"""An independent statement of the equations, in NumPy and SciPy alone, that the package is held against.

Nothing here may import what it judges, save `scenes`, which describes one scene in both languages.
"""
