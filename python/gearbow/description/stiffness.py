"""Teeth of a mesh: how stiff they are, how their tips are relieved, and what they err unloaded.

A stiffness is that of the whole mesh along its line of action. Three models are made of tooth pairs
that travel along the path of contact, so that they follow the moving centres: a pair carries while
it is between the tip circles. The others are functions of the mesh cycle, or constant.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from numpy.typing import ArrayLike

from gearbow.description.part import Part, freeze

__all__ = ["Stiffness"]


@dataclass(frozen=True)
class Stiffness(Part):
    """Stiffness of a mesh along its line of action; made by one of its constructors.

    Parameters
    ----------
    model : {"constant", "iso6336", "square", "parabolic", "potential_energy", "table", "fourier"}
        The family.
    mean : float, optional
        Mean of the mesh over its cycle, for the centres at rest [N/m].
    pair : float, optional
        One tooth pair where it is stiffest [N/m], for "square" and "parabolic".
    end_ratio : float, optional
        Stiffness of a pair at the ends of the path of contact over that in the middle, for
        "parabolic".
    values : sequence of float, optional
        Stiffness at equal parts of the mesh cycle [N/m], for "table".
    amplitudes : sequence of float, optional
        Amplitudes of the harmonics of the mesh cycle [N/m], for "fourier".
    phases : sequence of float, optional
        Phases of the harmonics [rad], for "fourier".
    bore_radii : pair of float, optional
        Radii at which the blanks of driver and driven gear are held [m], for "potential_energy".
    foundation : {"separate", "shared"}, optional
        Whether pairs in contact at once share the compliance of fillet and blank, for
        "potential_energy".
    engagement : "sharp" or float, optional
        How a tooth pair comes into contact, for the models that are made of pairs.
    phase : {"twist", "prescribed"}, optional
        What moves the teeth along the path of contact.

    Notes
    -----
    With s_j = s + j·p_b the place of pair j on the path of contact, p_b the base pitch, and lo and
    hi the ends of the path, the mesh of pairs stores U = ½ Σ_j w_j k(s_j) (δ − r_j)², where w_j is
    the engagement of the pair, r_j its tip relief and δ the deflection. The place s follows the
    turning of the driver and the operating pressure angle, lo follows the distance of the centres.

    ``engagement="sharp"`` makes a pair carry all or nothing; an integration step ends where one
    comes or goes. A number is the part of the base pitch over which it comes in, by a polynomial
    that is twice differentiable, half of it before and half after the end of the path; at most 0.5,
    and 0.1 if left out.

    ``phase="prescribed"``, the default, moves the teeth by the spin of the driver and the centres,
    not by its twist; what holds the speed does work through the stiffness. ``phase="twist"`` adds
    the twist, and the force −∂U/∂q that goes with it, so that an undamped train conserves its
    energy: what damping takes then slows down a train that is free to roll. It needs a smooth
    engagement.

    Examples
    --------
    >>> import gearbow as gb
    >>> gb.Stiffness.square(pair=2e8, engagement=0.2).pair
    200000000.0
    >>> gb.Stiffness.fourier(2e8, [3e7, 1e7]).amplitudes
    (30000000.0, 10000000.0)
    """

    model: str
    mean: float | None = None
    pair: float | None = None
    end_ratio: float | None = None
    values: Sequence[float] | None = None
    amplitudes: Sequence[float] | None = None
    phases: Sequence[float] | None = None
    bore_radii: Sequence[float] | None = None
    engagement: str | float | None = None
    phase: str | None = None
    foundation: str | None = None

    def __post_init__(self) -> None:
        freeze(self, "values", "amplitudes", "phases", "bore_radii")

    @classmethod
    def constant(cls, mean: float) -> "Stiffness":
        """Take the same stiffness always.

        Parameters
        ----------
        mean : float
            Stiffness [N/m].

        Returns
        -------
        Stiffness
            The stiffness; a plain number in its place says the same.
        """
        return cls("constant", mean=mean)

    @classmethod
    def iso6336(cls) -> "Stiffness":
        """Take the mean of ISO 6336-1 for steel gears with the standard basic rack.

        Returns
        -------
        Stiffness
            The mesh stiffness c_γ times the smaller face width: constant, with the contact ratio of
            the centres at rest. Both gears need their `face_width`.

        Notes
        -----
        ISO 6336-1:2006, clause 9, method B, for solid disks: c_γ = c(0.75 ε_α + 0.25), with the
        stiffness c of one pair, which is 0.8 of its theoretical one.
        """
        return cls("iso6336")

    @classmethod
    def square(
        cls,
        mean: float | None = None,
        *,
        pair: float | None = None,
        engagement: str | float | None = None,
        phase: str | None = None,
    ) -> "Stiffness":
        """Take pairs that are as stiff everywhere on the path of contact.

        Parameters
        ----------
        mean : float
            Mean of the mesh over its cycle, for the centres at rest [N/m]; either this or `pair`.
        pair : float
            One pair [N/m].
        engagement : "sharp" or float
            How a pair comes into contact: at once, or over this part of the base pitch; 0.1 if left
            out.
        phase : {"twist", "prescribed"}
            What moves the teeth along the path of contact; the class says more.

        Returns
        -------
        Stiffness
            The stiffness, a square wave: `pair` times the number of pairs in contact.
        """
        return cls("square", mean=mean, pair=pair, engagement=engagement, phase=phase)

    @classmethod
    def parabolic(
        cls,
        mean: float | None = None,
        *,
        pair: float | None = None,
        end_ratio: float | None = None,
        engagement: str | float | None = None,
        phase: str | None = None,
    ) -> "Stiffness":
        """Take pairs whose stiffness falls as a parabola towards the ends of the path of contact.

        Parameters
        ----------
        mean : float
            Mean of the mesh over its cycle, for the centres at rest [N/m]; either this or `pair`.
        pair : float
            One pair in the middle of the path [N/m].
        end_ratio : float
            What is left of that at the ends of the path of the centres at rest; 0.6 if left out.
        engagement : "sharp" or float
            How a pair comes into contact: at once, or over this part of the base pitch; 0.1 if left
            out.
        phase : {"twist", "prescribed"}
            What moves the teeth along the path of contact; the class says more.

        Returns
        -------
        Stiffness
            The stiffness.
        """
        return cls(
            "parabolic",
            mean=mean,
            pair=pair,
            end_ratio=end_ratio,
            engagement=engagement,
            phase=phase,
        )

    @classmethod
    def potential_energy(
        cls,
        bore_radii: Sequence[float] | None = None,
        *,
        engagement: str | float | None = None,
        phase: str | None = None,
        foundation: str | None = None,
    ) -> "Stiffness":
        """Take pairs from their teeth: bending, shear, compression, blank and contact.

        Parameters
        ----------
        bore_radii : pair of float
            Radii at which the blanks of driver and driven gear are held [m], below their root
            circles; the radii of their shafts if left out.
        engagement : "sharp" or float
            How a pair comes into contact: at once, or over this part of the base pitch; 0.1 if left
            out.
        phase : {"twist", "prescribed"}
            What moves the teeth along the path of contact; the class says more.
        foundation : {"separate", "shared"}
            Fillet and blank: "separate" gives each tooth pair a compliance of its own, as in most
            publications; it counts the blank twice where two pairs are in contact, in parallel,
            and overestimates the stiffness there. "shared" lets all pairs in contact load the same
            blanks. "separate" if left out.

        Returns
        -------
        Stiffness
            The stiffness of steel teeth of the smaller face width. Both gears need theirs.

        Warns
        -----
        SceneWarning
            By the system, if a root circle is not 1.4 to 7 times its bore radius (both with the two
            digits that the source prints): the formula of fillet and blank was fitted for these.

        Notes
        -----
        With ``foundation="shared"`` a pair i in contact deflects pair j by f_i f_j times its force,
        where f² is the compliance of both blanks for a pair at its place: the stiffness of the mesh
        is K = Σκ − (Σκf)²/(1 + Σκf²), with the stiffness κ of each pair without the blanks. It
        cannot be combined with tip relief.

        Each tooth is a cantilever, the involute down to the base circle and straight from there to
        the root: Yang and Lin, *Hertzian damping, tooth friction and bending elasticity in gear
        impact dynamics*, J. Mech. Transm. Autom. Des. 109 (1987), with shear after Tian, *Dynamic
        simulation for system response of gearbox including localized gear faults* (2004); fillet
        and blank: Sainsot, Velex and Duverger, *Contribution of gear body to tooth deflections*, J.
        Mech. Des. 126 (2004); contact: Yang and Sun, *A rotary model for spur gear dynamics*, J.
        Mech. Transm. Autom. Des. 107 (1985).
        """
        return cls(
            "potential_energy",
            bore_radii=bore_radii,
            engagement=engagement,
            phase=phase,
            foundation=foundation,
        )

    @classmethod
    def table(cls, values: ArrayLike, *, phase: str | None = None) -> "Stiffness":
        """Take values over the mesh cycle, e.g. from a finite element analysis.

        Parameters
        ----------
        values : array_like, shape (n,)
            Stiffness at 0, 1/n, 2/n, … of the mesh cycle [N/m], at least three. The cycle begins
            where a pair is at the interference point of the driver, s = 0.
        phase : {"twist", "prescribed"}
            What moves the teeth along the path of contact; the class says more.

        Returns
        -------
        Stiffness
            The stiffness, a periodic cubic spline through the values.
        """
        return cls("table", values=values, phase=phase)  # type: ignore[arg-type]  # made a tuple

    @classmethod
    def fourier(
        cls,
        mean: float,
        amplitudes: ArrayLike,
        phases: ArrayLike | None = None,
        *,
        phase: str | None = None,
    ) -> "Stiffness":
        """Take harmonics of the mesh cycle.

        Parameters
        ----------
        mean : float
            Mean over the cycle [N/m].
        amplitudes : array_like, shape (n,)
            Amplitudes a of the harmonics 1, 2, … [N/m].
        phases : array_like, shape (n,)
            Their phases p [rad]; zero if left out.
        phase : {"twist", "prescribed"}
            What moves the teeth along the path of contact; the class says more.

        Returns
        -------
        Stiffness
            The stiffness mean + Σ a_n cos(2πn s/p_b + p_n), with the place s of a pair on the path
            of contact and the base pitch p_b.
        """
        return cls("fourier", mean=mean, amplitudes=amplitudes, phases=phases, phase=phase)  # type: ignore[arg-type]  # made tuples
