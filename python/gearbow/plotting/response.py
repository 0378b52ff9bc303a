"""Figures of time responses: orbits, time histories, spectra and energies."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from gearbow._types import Array
from gearbow.plotting.style import MICRO, PALETTE, colour, legend, panels

__all__ = ["energy_balance", "history", "mesh", "orbits", "spectrum", "twist"]


def orbits(motion: Mapping[str, Array]) -> Figure:
    """Draw the orbit of each centre in the plane of rotation.

    Parameters
    ----------
    motion : mapping of {str: ndarray of shape (k, 2)}
        Displacements v and w [m] by label.

    Returns
    -------
    matplotlib.figure.Figure
        One panel for each centre: w against v [µm]. A dot marks the end.
    """
    count = len(motion)
    with panels(count, 3.8, columns=4, width=4.0 * min(4, count)) as (figure, axes):
        for panel, (label, values) in zip(axes, motion.items(), strict=True):
            v, w = MICRO * values.T
            panel.plot(v, w)
            panel.plot(v[-1:], w[-1:], "o", color=PALETTE[1])
            panel.set(title=label, xlabel="v [µm]", ylabel="w [µm]")
            panel.set_aspect("equal", adjustable="datalim")
            panel.locator_params(nbins=5)
    return figure


def history(time: Array, motion: Mapping[str, Array]) -> Figure:
    """Draw the displacement of each centre against time.

    Parameters
    ----------
    time : ndarray, shape (k,)
        Times [s].
    motion : mapping of {str: ndarray of shape (k, 2)}
        Displacements v and w [m] by label.

    Returns
    -------
    matplotlib.figure.Figure
        One panel for each centre: v and w [µm].
    """
    with panels(len(motion), 2.4, columns=1, sharex=True) as (figure, axes):
        for panel, (label, values) in zip(axes, motion.items(), strict=True):
            panel.plot(time, MICRO * values, label=["v", "w"])
            panel.set(ylabel=f"{label} [µm]")
        axes[-1].set(xlabel="time [s]")
        legend(figure, axes[0])
    return figure


def twist(time: Array, twists: Mapping[str, Array]) -> Figure:
    """Draw the twist of each place against time.

    Parameters
    ----------
    time : ndarray, shape (k,)
        Times [s].
    twists : mapping of {str: ndarray of shape (k,)}
        Twist [rad] by label.

    Returns
    -------
    matplotlib.figure.Figure
        One panel for each place: twist [mrad].
    """
    with panels(len(twists), 2.4, columns=1, sharex=True) as (figure, axes):
        for panel, (label, values) in zip(axes, twists.items(), strict=True):
            panel.plot(time, 1e3 * values)
            panel.set(ylabel=f"{label} [mrad]")
        axes[-1].set(xlabel="time [s]")
    return figure


def mesh(time: Array, meshes: Mapping[tuple[str, str], tuple[Array, Array, Array]]) -> Figure:
    """Draw the geometry of the meshes at the moving centres.

    Parameters
    ----------
    time : ndarray, shape (k,)
        Times [s].
    meshes : mapping of {(str, str): tuple of ndarray of shape (k,)}
        Contact ratio, pressure angle [rad] and angle of the line of centres [rad] of each mesh
        (driver, driven).

    Returns
    -------
    matplotlib.figure.Figure
        A column for each mesh: contact ratio, pressure angle [°] and angle of the line of centres
        [°].
    """
    columns = len(meshes)
    with panels(3 * columns, 2.6, columns=columns, width=max(9.0, 6.0 * columns), sharex=True) as (
        figure,
        axes,
    ):
        for column, ((driver, driven), geometry) in enumerate(meshes.items()):
            contact_ratio, pressure_angle, centre_line_angle = geometry
            rows = {
                "contact ratio": contact_ratio,
                "pressure angle [°]": np.degrees(pressure_angle),
                "line of centres [°]": np.degrees(centre_line_angle),
            }
            for row, (label, values) in enumerate(rows.items()):
                panel = axes[row * columns + column]
                panel.plot(time, values, color=colour(column))
                panel.set(ylabel=label)
                # Ticks without an offset show an angle of 20.01° in full.
                panel.ticklabel_format(axis="y", useOffset=False)
            axes[column].set(title=f"{driver} – {driven}")
            axes[2 * columns + column].set(xlabel="time [s]")
    return figure


def spectrum(spectra: Mapping[str, tuple[Array, Array]]) -> Figure:
    """Draw the amplitude spectrum of the displacement of each centre.

    Parameters
    ----------
    spectra : mapping of {str: (ndarray of shape (n,), ndarray of shape (n, 2))}
        Frequencies [Hz] and amplitudes of v and w [m] by label.

    Returns
    -------
    matplotlib.figure.Figure
        One panel for each centre: amplitudes of v and w [µm] against frequency [Hz].
    """
    highest = 0.0
    with panels(len(spectra), 2.4, columns=1, sharex=True) as (figure, axes):
        for panel, (label, (frequency, amplitude)) in zip(axes, spectra.items(), strict=True):
            panel.semilogy(frequency, MICRO * amplitude, label=["v", "w"])
            panel.set(ylabel=f"{label} [µm]")
            # Smaller amplitudes are round-off.
            top = amplitude.max()
            if top > 0.0:
                panel.set_ylim(MICRO * 1e-6 * top, MICRO * 2.0 * top)
                highest = max(highest, frequency[np.any(amplitude > 1e-6 * top, axis=1)][-1])
        if highest > 0.0:
            axes[-1].set_xlim(0.0, 1.1 * highest)
        axes[-1].set(xlabel="frequency [Hz]")
        legend(figure, axes[0])
    return figure


def energy_balance(time: Array, rows: Mapping[str, tuple[Mapping[str, Array], Array]]) -> Figure:
    """Draw energies, works and the residual against time.

    Parameters
    ----------
    time : ndarray, shape (k,)
        Times [s].
    rows : mapping of {str: (mapping of {str: ndarray of shape (k,)}, ndarray of shape (k,))}
        Terms by name and their sum [J], for each panel.

    Returns
    -------
    matplotlib.figure.Figure
        One panel for each entry [J]. Terms that are zero throughout are omitted.
    """
    with panels(len(rows), 3.0, columns=1, sharex=True) as (figure, axes):
        for panel, (label, (terms, total)) in zip(axes, rows.items(), strict=True):
            for i, (name, values) in enumerate(terms.items()):
                if np.any(values != 0.0):
                    panel.plot(time, values, color=colour(i), label=name)
            panel.plot(time, total, color=PALETTE[-1], label="all")
            panel.set(ylabel=f"{label} [J]")
            if terms:
                panel.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        axes[-1].set(xlabel="time [s]")
    return figure
