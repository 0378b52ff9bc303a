"""Matrices of one Timoshenko shaft element and of one rigid disk, by Gauss quadrature of energies.

Coordinates of a node, in this order: v, w (along y, z), B, G (rotations about y, z), t (twist about x).
Small slopes: dv/dx = G, dw/dx = -B. The shape functions are the static solutions of the Timoshenko
beam (Przemieniecki 1968; Nelson 1980). Stiffness and mass are integrals of the strain and kinetic
energies. They do not use the closed forms, so the tests detect an error in either form.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

V, W, B, G, T = range(5)  # indices of a node's coordinates
XY = np.array([V, G, 5 + V, 5 + G])  # (v1, G1, v2, G2)
XZ = np.array([W, B, 5 + W, 5 + B])  # (w1, -B1, w2, -B2) after the signs
SIGNS = np.diag([1.0, -1.0, 1.0, -1.0])


@dataclass(frozen=True)
class Section:
    """A hollow circular section of one material."""

    outer_diameter: float
    youngs_modulus: float
    shear_modulus: float
    density: float
    inner_diameter: float = 0.0
    shear: bool = True

    @property
    def area(self) -> float:
        return np.pi / 4 * (self.outer_diameter**2 - self.inner_diameter**2)

    @property
    def moment(self) -> float:
        return np.pi / 64 * (self.outer_diameter**4 - self.inner_diameter**4)

    @property
    def poisson(self) -> float:
        return self.youngs_modulus / (2 * self.shear_modulus) - 1

    @property
    def kappa(self) -> float:
        """Give Cowper's shear coefficient of a hollow circular section."""
        nu, m2 = self.poisson, (self.inner_diameter / self.outer_diameter) ** 2
        bracket = (1 + m2) ** 2
        return 6 * (1 + nu) * bracket / ((7 + 6 * nu) * bracket + (20 + 12 * nu) * m2)

    def shear_parameter(self, length: float) -> float:
        if not self.shear:
            return 0.0
        stiffness = self.kappa * self.shear_modulus * self.area
        return 12 * self.youngs_modulus * self.moment / (stiffness * length**2)


def shape_functions(xi: float, l: float, phi: float) -> tuple[Array, Array, Array]:
    """Give deflection, section rotation and curvature at xi = x/l as rows on (v1, G1, v2, G2)."""
    x2, x3 = xi**2, xi**3
    deflection = [
        1 - 3 * x2 + 2 * x3 + (1 - xi) * phi,
        l * (xi - 2 * x2 + x3 + (xi - x2) * phi / 2),
        3 * x2 - 2 * x3 + xi * phi,
        l * (-x2 + x3 - (xi - x2) * phi / 2),
    ]
    rotation = [
        6 / l * (-xi + x2),
        1 - 4 * xi + 3 * x2 + (1 - xi) * phi,
        6 / l * (xi - x2),
        -2 * xi + 3 * x2 + xi * phi,
    ]
    curvature = [
        6 / l**2 * (-1 + 2 * xi),
        (-4 + 6 * xi - phi) / l,
        6 / l**2 * (1 - 2 * xi),
        (-2 + 6 * xi + phi) / l,
    ]
    scale = 1 / (1 + phi)
    return scale * np.array(deflection), scale * np.array(rotation), scale * np.array(curvature)


def shear_strain(phi: float, l: float) -> Array:
    """Give v' minus the section rotation, which is constant along the element."""
    return phi / (1 + phi) * np.array([-1 / l, -0.5, 1 / l, -0.5])


def beam(section: Section, l: float) -> tuple[Array, Array, Array]:
    """Give mass, stiffness and gyroscopic matrix per unit spin (10 x 10) of one element."""
    phi = section.shear_parameter(l)
    e, g, rho = section.youngs_modulus, section.shear_modulus, section.density
    area, moment = section.area, section.moment
    translation, rotary, bending = np.zeros((4, 4)), np.zeros((4, 4)), np.zeros((4, 4))
    points, weights = np.polynomial.legendre.leggauss(
        4
    )  # exact to degree 7; the integrands have degree 6
    for point, weight in zip(points, weights, strict=True):
        n_v, n_t, n_c = shape_functions((point + 1) / 2, l, phi)
        share = weight * l / 2
        translation += rho * area * share * np.outer(n_v, n_v)
        rotary += rho * moment * share * np.outer(n_t, n_t)
        bending += e * moment * share * np.outer(n_c, n_c)
    if section.shear:
        strain = shear_strain(phi, l)
        bending += section.kappa * g * area * l * np.outer(strain, strain)

    mass, stiffness, gyroscopic = np.zeros((10, 10)), np.zeros((10, 10)), np.zeros((10, 10))
    for matrix, plane in ((mass, translation + rotary), (stiffness, bending)):
        matrix[np.ix_(XY, XY)] = plane
        matrix[np.ix_(XZ, XZ)] = SIGNS @ plane @ SIGNS
    gyroscopic[np.ix_(XZ, XY)] = -2 * SIGNS @ rotary
    gyroscopic[np.ix_(XY, XZ)] = 2 * rotary @ SIGNS
    twist = np.ix_([T, 5 + T], [T, 5 + T])
    polar = 2 * moment
    mass[twist] = rho * polar * l / 6 * np.array([[2.0, 1.0], [1.0, 2.0]])
    stiffness[twist] = g * polar / l * np.array([[1.0, -1.0], [-1.0, 1.0]])
    return mass, stiffness, gyroscopic


def disk(mass: float, diametral: float, polar: float) -> tuple[Array, Array]:
    """Give mass and gyroscopic matrix (5 x 5) of a rigid disk: I_d B'' + spin I_p G' = M_y."""
    gyroscopic = np.zeros((5, 5))
    gyroscopic[B, G] = polar
    gyroscopic[G, B] = -polar
    return np.diag([mass, mass, diametral, diametral, polar]), gyroscopic
