"""Stiffness of a mesh: constant, of tooth pairs, or a function of the mesh cycle.

A stiffness is that of the whole mesh along its line of action. Three models consist of tooth pairs
that travel along the path of contact and depend on the moving centres: a pair carries load while it
is between the tip circles. The other models are functions of the mesh cycle, or constant.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from numpy.typing import ArrayLike

from gearbow._types import Foundation, MeshPhase, StiffnessModel
from gearbow.description.part import Part, freeze


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
        Largest stiffness of one tooth pair [N/m], for "square" and "parabolic"; of helical teeth
        where the pair touches over its whole face width.
    end_ratio : float, optional
        Stiffness of a pair at the ends of the path over that in the middle, for "parabolic".
    values : sequence of float, optional
        Stiffness at equal intervals of the mesh cycle [N/m], for "table".
    amplitudes, phases : sequence of float, optional
        Amplitudes [N/m] and phases [rad] of the harmonics of the mesh cycle, for "fourier".
    bore_radii : pair of float, optional
        Radii at which the bodies of driver and driven gear are fixed [m], for "potential_energy".
    engagement : "sharp" or float, optional
        Engagement of a tooth pair, for the models that consist of pairs.
    phase : {"twist", "prescribed"}, optional
        What determines the position of the teeth on the path of contact.
    foundation : {"separate", "shared"}, optional
        Whether pairs share the compliance of fillet and gear body, for "potential_energy".

    Notes
    -----
    A mesh of tooth pairs stores the energy U = ½ Σ_j w_j k(s_j) (δ − r_j)². Here s_j = s + j·p_b is
    the position of pair j on the path of contact, p_b the base pitch, w_j the engagement of the
    pair, r_j its tip relief and δ the deflection. The position s depends on the rotation of the
    driver and on the operating pressure angle. The lower end lo of the path depends on the centre
    distance.

    With ``engagement="sharp"`` the engagement is 0 or 1; an integration step ends where a pair
    enters or leaves contact. A number is the length of the engagement as a fraction of the base
    pitch, at most 0.5; the default is 0.1. The engagement then is a twice differentiable
    polynomial, half before and half after the end of the path.

    With ``phase="prescribed"``, the default, the position s depends on the prescribed rotation of
    the driver and on the centres, not on the twist of the driver; the drive does work through the
    stiffness. ``phase="twist"`` adds the twist and the corresponding force −∂U/∂q, so that an
    undamped train conserves its energy; damping then slows down a train that is free to rotate. It
    needs a smooth engagement.

    Stiffnesses in N/m are normal to the teeth. For helical gears that is along the unit normal in
    space; the stiffness of the transverse section is cos²β_b times as large, with the base helix
    angle β_b. A pair of helical teeth touches along a line across the face: its stiffness is that
    of the transverse sections, integrated over the face width, which both gears then need. Tip
    relief and a shared foundation are for spur gears only.

    Examples
    --------
    >>> import gearbow as gb
    >>> gb.Stiffness.square(pair=2e8, engagement=0.2).pair
    200000000.0
    >>> gb.Stiffness.fourier(2e8, [3e7, 1e7]).amplitudes
    (30000000.0, 10000000.0)
    """

    model: StiffnessModel
    mean: float | None = None
    pair: float | None = None
    end_ratio: float | None = None
    values: Sequence[float] | None = None
    amplitudes: Sequence[float] | None = None
    phases: Sequence[float] | None = None
    bore_radii: Sequence[float] | None = None
    engagement: str | float | None = None
    phase: MeshPhase | None = None
    foundation: Foundation | None = None

    def __post_init__(self) -> None:
        freeze(self, "values", "amplitudes", "phases", "bore_radii")

    @classmethod
    def constant(cls, mean: float) -> "Stiffness":
        """Make a constant stiffness.

        Parameters
        ----------
        mean : float
            Stiffness [N/m].

        Returns
        -------
        Stiffness
            The stiffness; a plain number has the same meaning.
        """
        return cls("constant", mean=mean)

    @classmethod
    def iso6336(cls) -> "Stiffness":
        """Use the mean stiffness of ISO 6336-1 for steel gears with the standard basic rack.

        Returns
        -------
        Stiffness
            The mesh stiffness c_γ times the smaller face width. It is constant and uses the contact
            ratio of the centres at rest. Both gears need a `face_width`.

        Notes
        -----
        ISO 6336-1:2006, clause 9, method B, for solid disks: c_γ = c(0.75 ε_α + 0.25), with the
        stiffness c of one pair, which is 0.8 times its theoretical stiffness. For helical gears it
        has the virtual numbers of teeth z/cos³β, the factor cos β and the transverse contact ratio
        ε_α, and is that of the transverse section; divided by cos²β_b it is normal to the teeth.
        """
        return cls("iso6336")

    @classmethod
    def square(
        cls,
        mean: float | None = None,
        *,
        pair: float | None = None,
        engagement: str | float | None = None,
        phase: MeshPhase | None = None,
    ) -> "Stiffness":
        """Use pairs with a uniform stiffness on the path of contact.

        Parameters
        ----------
        mean : float
            Mean of the mesh over its cycle, for the centres at rest [N/m]; give this or `pair`.
        pair : float
            Stiffness of one pair [N/m].
        engagement, phase : optional
            Engagement of a pair, and what determines the position of the teeth; see the class.

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
        phase: MeshPhase | None = None,
    ) -> "Stiffness":
        """Use pairs whose stiffness decreases as a parabola to the ends of the path of contact.

        Parameters
        ----------
        mean : float
            Mean of the mesh over its cycle, for the centres at rest [N/m]; give this or `pair`.
        pair : float
            Stiffness of one pair in the middle of the path [N/m].
        end_ratio : float
            Stiffness at the ends of the path over `pair`, for the centres at rest; 0.6 by default.
        engagement, phase : optional
            Engagement of a pair, and what determines the position of the teeth; see the class.
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
        phase: MeshPhase | None = None,
        foundation: Foundation | None = None,
    ) -> "Stiffness":
        """Use pairs of the potential-energy method: bending, shear, compression, body and contact.

        Parameters
        ----------
        bore_radii : pair of float
            Radii at which the bodies of driver and driven gear are fixed [m], below their root
            circles; the defaults are the radii of their shafts.
        engagement, phase : optional
            Engagement of a pair, and what determines the position of the teeth; see the class.
        foundation : {"separate", "shared"}
            Fillet and gear body. "separate" gives each tooth pair its own compliance, as in most
            publications; where two pairs are in contact, it counts the body twice, in parallel,
            and overestimates the stiffness. With "shared" all pairs in contact load the same
            gear bodies. The default is "separate".

        Returns
        -------
        Stiffness
            The stiffness of steel teeth with the smaller face width. Both gears need a face width.

        Warns
        -----
        SceneWarning
            By the system, if a root circle radius is not 1.4 to 7 times the bore radius, the range
            (with the two digits of the source) for which the formula of the gear body was fitted.

        Notes
        -----
        With ``foundation="shared"`` a pair i in contact deflects pair j by f_i f_j times its force,
        where f² is the compliance of both bodies for a pair at its position. The mesh stiffness
        is K = Σκ − (Σκf)²/(1 + Σκf²), with the stiffness κ of each pair without the bodies. It
        cannot be combined with tip relief.

        The transverse sections of helical teeth are spur teeth with the transverse pressure angle
        (accumulated integral potential energy method, Wan et al., Mech. Mach. Theory 92 (2015)).

        Each tooth is a cantilever with an involute profile down to the base circle and a straight
        profile from there to the root: Yang and Lin, *Hertzian damping, tooth friction and bending
        elasticity in gear impact dynamics*, J. Mech. Transm. Autom. Des. 109 (1987), with shear
        after Tian, *Dynamic simulation for system response of gearbox including localized gear
        faults* (2004); fillet and gear body: Sainsot, Velex and Duverger, *Contribution of gear
        body to tooth deflections*, J. Mech. Des. 126 (2004); contact: Yang and Sun, *A rotary model
        for spur gear dynamics*, J. Mech. Transm. Autom. Des. 107 (1985).
        """
        return cls(
            "potential_energy",
            bore_radii=bore_radii,
            engagement=engagement,
            phase=phase,
            foundation=foundation,
        )

    @classmethod
    def table(cls, values: "ArrayLike", *, phase: MeshPhase | None = None) -> "Stiffness":
        """Interpolate values over the mesh cycle, e.g. from a finite element analysis.

        Parameters
        ----------
        values : array_like, shape (n,)
            Stiffness at 0, 1/n, 2/n, … of the mesh cycle [N/m], at least three. The cycle begins
            when a pair is at the interference point of the driver, s = 0.
        phase : {"twist", "prescribed"}
            What determines the position of the teeth on the path of contact; see the class.

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
        amplitudes: "ArrayLike",
        phases: "ArrayLike | None" = None,
        *,
        phase: MeshPhase | None = None,
    ) -> "Stiffness":
        """Sum harmonics of the mesh cycle.

        Parameters
        ----------
        mean : float
            Mean over the cycle [N/m].
        amplitudes, phases : array_like, shape (n,)
            Amplitudes a [N/m] and phases p [rad] of the harmonics 1, 2, …; p is 0 by default.
        phase : {"twist", "prescribed"}
            What determines the position of the teeth on the path of contact; see the class.

        Returns
        -------
        Stiffness
            The stiffness mean + Σ a_n cos(2πn s/p_b + p_n), with the position s of a pair on the
            path of contact and the base pitch p_b.
        """
        return cls("fourier", mean=mean, amplitudes=amplitudes, phases=phases, phase=phase)  # type: ignore[arg-type]  # made tuples
