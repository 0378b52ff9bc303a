"""Closed forms without finite elements: simply supported shafts, one-disk rotors, rigid gears."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reference.elements import Section


def jeffcott(ratio: float, bow: complex, eccentricity: complex, damping: float) -> complex:
    """Give the disk whirl v + iw in the rotating frame; `ratio` is spin over critical speed.

    Source: Nicholas, Gunter and Allaire 1976.
    """
    return (bow + eccentricity * ratio**2) / (1 - ratio**2 + 2j * damping * ratio)


def bowed_shaft(section: Section, length: float, speed: float, half_waves: int = 1) -> float:
    """Give the ratio of amplitude to sine-bow amplitude of a simply supported shaft at `speed`."""
    k = half_waves * np.pi / length
    ei = section.youngs_modulus * section.moment
    rho_a, rho_i = section.density * section.area, section.density * section.moment
    if not section.shear:
        # rotation = slope; the shear force drops out of the sum of the two equations
        return ei * k**4 / (ei * k**4 - rho_a * speed**2 + rho_i * k**2 * speed**2)
    kga = section.kappa * section.shear_modulus * section.area
    matrix = np.array(
        [
            [kga * k**2 - rho_a * speed**2, -kga * k],
            [-kga * k, kga + ei * k**2 + rho_i * speed**2],
        ]
    )
    rotation = k  # the stress-free section is perpendicular to the stress-free line
    right = np.array([kga * k**2 - kga * k * rotation, -kga * k + (kga + ei * k**2) * rotation])
    return float(np.linalg.solve(matrix, right)[0])


def simply_supported(
    section: Section, length: float, half_waves: int, spin: float = 0.0
) -> tuple[float, float]:
    """Give backward and forward whirl frequency of the lower branch (both positive, rad/s)."""
    k = half_waves * np.pi / length
    ei = section.youngs_modulus * section.moment
    rho_a, rho_i = section.density * section.area, section.density * section.moment
    if section.shear:
        kga = section.kappa * section.shear_modulus * section.area
        force = np.array([-rho_a, 0.0, kga * k**2])
        moment = np.array([-rho_i, 2 * rho_i * spin, kga + ei * k**2])
        roots = np.roots(np.polysub(np.polymul(force, moment), [(kga * k) ** 2]))
    else:
        roots = np.roots([-(rho_a + rho_i * k**2), 2 * rho_i * k**2 * spin, ei * k**4])
    roots = np.real(roots)
    return float(-np.max(roots[roots < 0])), float(np.min(roots[roots > 0]))


def support_shift(section: Section, length: float, half_waves: int, support: float) -> float:
    """Give the first-order relative frequency reduction by two equal end springs.

    The shaft is simply supported on the springs. Each spring carries half of the inertia force of a
    unit sine, rho A omega^2 / k. Its flexibility reduces the modal stiffness by the square of this
    force divided by the spring stiffness.
    """
    k = half_waves * np.pi / length
    rho_a, rho_i = section.density * section.area, section.density * section.moment
    omega = simply_supported(section, length, half_waves)[0]
    rotation = k
    if section.shear:
        kga = section.kappa * section.shear_modulus * section.area
        rotation = (kga * k**2 - rho_a * omega**2) / (kga * k)
    modal_mass = (rho_a + rho_i * rotation**2) * length / 2
    reaction = rho_a * omega**2 / k
    return reaction**2 / (support * omega**2 * modal_mass)


def element_error(section: Section, length: float, half_waves: int, elements: int) -> float:
    """Give the leading relative error of a simply supported frequency with equal elements.

    The cubic deflection has the error (kh)^4/1440. The shear strain is constant along an element.
    This adds (kh)^2/12 times the fraction of the compliance that is due to shear.
    """
    k = half_waves * np.pi / length
    kh2 = (k * length / elements) ** 2
    error = kh2**2 / 1440
    if section.shear:
        kga = section.kappa * section.shear_modulus * section.area
        error += kh2 / 24 * section.youngs_modulus * section.moment * k**2 / kga
    return error


def free_torsion(section: Section, length: float, number: int) -> float:
    return number * np.pi / length * np.sqrt(section.shear_modulus / section.density)


def free_torsion_of_elements(section: Section, length: float, number: int, elements: int) -> float:
    """Give the same error, exactly, for a chain of equal two-node elements with consistent mass."""
    h = length / elements
    c = np.cos(number * np.pi / elements)
    return float(np.sqrt(6 * section.shear_modulus / section.density * (1 - c) / (2 + c)) / h)


def forward_backward(amplitudes: NDArray[np.complex128]) -> tuple[complex, complex]:
    """Give forward and backward whirl of v = Re[Y exp(i a)], w = Re[Z exp(i a)].

    The whirl is v + iw = forward exp(i a) + backward exp(-i a).
    """
    y, z = amplitudes
    return complex((y + 1j * z) / 2), complex(np.conj(y - 1j * z) / 2)


def geared_pair(
    stiffness: float, radii: tuple[float, float], inertias: tuple[float, float]
) -> float:
    """Give the torsional frequency of two rigid gears coupled by their mesh."""
    return float(np.sqrt(stiffness * (radii[0] ** 2 / inertias[0] + radii[1] ** 2 / inertias[1])))


def geared_chain(
    stiffnesses: list[float], radii: list[tuple[float, float]], inertias: list[float]
) -> NDArray[np.float64]:
    """Give the frequencies of rigid shafts 0..n coupled by n meshes with radii (driver, driven)."""
    n = len(inertias)
    stiffness = np.zeros((n, n))
    sign = 1.0
    for i, (k, (r_a, r_b)) in enumerate(zip(stiffnesses, radii, strict=True)):
        g = np.zeros(n)
        g[i], g[i + 1] = sign * r_a, sign * r_b
        stiffness += k * np.outer(g, g)
        sign = -sign
    root = 1 / np.sqrt(np.array(inertias))
    squares = np.linalg.eigvalsh(stiffness * np.outer(root, root))
    return np.sqrt(np.abs(squares))


def full_depth_gear(
    teeth: int, module: float, pressure_angle: float = np.radians(20)
) -> dict[str, float]:
    """Give base, pitch and tip radius and base pitch of a standard gear without profile shift."""
    pitch = module * teeth / 2
    base = pitch * np.cos(pressure_angle)
    return {
        "pitch": pitch,
        "base": base,
        "tip": pitch + module,
        "base_pitch": 2 * np.pi * base / teeth,
    }


def solid_disk(
    radius: float, width: float, density: float, bore: float = 0.0
) -> tuple[float, float, float]:
    """Give mass, diametral and polar inertia of a disk with bore radius `bore`."""
    mass = density * np.pi * (radius**2 - bore**2) * width
    squares = radius**2 + bore**2
    return mass, mass / 12 * (3 * squares + width**2), mass / 2 * squares
