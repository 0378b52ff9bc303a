"""Combinations of unknowns that the data cannot separate, in words."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from gearbow._types import Array
from gearbow.analysis.protocol import ratios_by_shaft
from gearbow.identification.fit import UNSEEN, WeightedFit
from gearbow.identification.responses import LinearModel

#: Smallest share of an unknown, or of a link of two unknowns, in a combination that is named.
_NAMED_SHARE = 0.05
#: Largest ratio of a speed to the first natural frequency at which the response to a bow is
#: nearly that of a run-out.
_LOW_SPEED = 0.7
#: Largest deviation of a factor from 1 or −1 that is called a sum or a difference.
_NEARLY_ONE = 0.05
#: Share of the variance of another unknown above which it shares the doubt of a combination.
_SHARED = 0.5


def component_groups(model: LinearModel[Any]) -> list[list[int]]:
    """Give the components of each unknown: (re, im) of a term, one of a parameter."""
    terms = len(model.terms)
    own = [[2 * j, 2 * j + 1] for j in range(terms)]
    return own + [[2 * terms + i] for i in range(len(model.parameters))]


def inseparable(model: LinearModel[Any], names: Sequence[str], fit: WeightedFit) -> tuple[str, ...]:
    """Name the combinations whose 95 % interval exceeds what alone explains all vibration."""
    lost = fit.singular_values < UNSEEN
    if not lost.any():
        return ()
    directions = fit.directions[lost]
    projector = directions.T @ directions
    groups = component_groups(model)
    links = np.array([[np.linalg.norm(projector[np.ix_(a, b)]) for b in groups] for a in groups])
    found = []
    for members in _clusters(links):
        components = [i for j in members for i in groups[j]]
        dimension = round(float(np.trace(projector[np.ix_(components, components)])))
        if len(members) == 1 or dimension >= len(components):
            found += [_unseen(model, names[j], j) for j in members]
        else:
            shared = _sharing(fit, groups, members)
            also = [names[j] for j in shared if links[j, j] <= _NAMED_SHARE]
            doubt = f"; this doubt is most of the interval of {_listed(also)}" if also else ""
            found.append(f"{_combined(model, names, members, fit)}{doubt}")
    return tuple(found)


def _sharing(fit: WeightedFit, groups: Sequence[list[int]], members: Sequence[int]) -> list[int]:
    """Find the unknowns whose variance comes mostly from what the data do not see of `members`."""
    of_members = [i for j in members for i in groups[j]]
    lost = (fit.directions[:, of_members] ** 2).sum(axis=1) > _SHARED
    lost &= fit.singular_values < UNSEEN
    # A singular value of zero has an infinite variance, of which any share is the whole.
    least = np.finfo(np.float64).eps * fit.singular_values.max(initial=0.0)
    sizes = np.maximum(fit.singular_values, max(least, np.finfo(np.float64).tiny))
    variances = (fit.directions / sizes[:, np.newaxis]) ** 2
    part, total = variances[lost].sum(axis=0), variances.sum(axis=0)
    return [j for j, own in enumerate(groups) if part[own].sum() > _SHARED * total[own].sum()]


def _listed(names: Sequence[str]) -> str:
    """List names in a sentence."""
    return " and ".join([text for text in (", ".join(names[:-1]), names[-1]) if text])


def _clusters(links: Array) -> list[list[int]]:
    """Find the groups of unknowns that appear together in lost directions."""
    waiting = [j for j in range(len(links)) if links[j, j] > _NAMED_SHARE]
    clusters = []
    while waiting:
        cluster, reached = [], [waiting.pop(0)]
        while reached:
            j = reached.pop()
            cluster.append(j)
            near = [k for k in waiting if links[j, k] > _NAMED_SHARE]
            reached += near
            waiting = [k for k in waiting if k not in near]
        clusters.append(sorted(cluster))
    return clusters


def _unseen(model: LinearModel[Any], name: str, index: int) -> str:
    """Say why one unknown cannot be found."""
    if index < len(model.terms):
        shaft = model.terms[index].shaft
        ratios = ratios_by_shaft(model.base)
        orders = [abs(ratios[channel.reference]) for channel in model.channels]
        if not np.isclose(orders, abs(ratios[shaft]), rtol=1e-9).any():
            return (
                f"{name}: unknown, because no probe has {shaft} as its reference: its vibration is "
                "at another order"
            )
    return (
        f"{name}: unknown, because its interval contains values that alone would cause the whole "
        f"measured vibration{_low_speed(model)}"
    )


def _combined(
    model: LinearModel[Any], names: Sequence[str], members: Sequence[int], fit: WeightedFit
) -> str:
    """Say what is known of several unknowns, and why not more."""
    listed = _listed([names[j] for j in members])
    what = "only their combined effect is known"
    terms = len(model.terms)
    if len(members) == 2 and max(members) < terms:
        first, second = (fit.derivative[:, 2 * j] for j in members)
        other = fit.derivative[:, 2 * members[0] + 1]
        # The second response as a complex multiple of the first one.
        size = first @ first
        factor = complex(first @ second / size, other @ second / size)
        if abs(factor - 1.0) < _NEARLY_ONE:
            what = "only their sum is known"
        elif abs(factor + 1.0) < _NEARLY_ONE:
            what = "only their difference is known"
        else:
            units = [model.terms[j].unit for j in members]
            unit = "" if units[0] == units[1] else f" [{units[0]}/({units[1]})]"
            angle = np.degrees(np.angle(factor))
            what = (
                f"only the first plus {abs(factor):.3g} ∠ {angle:.0f}°{unit} times the second "
                "is known"
            )
    low = _low_speed(model)
    shapes = ", because their responses have the same form at these probes and speeds"
    return f"{listed}: {what}{low or shapes}"


def _low_speed(model: LinearModel[Any]) -> str:
    """Say how far all speeds are below the first natural frequency, if they are."""
    modes = model.base.modes(0.0, count=min(10, len(model.base.dofs)))
    lateral = [
        frequency
        for frequency, whirl in zip(modes.frequencies_hz, modes.whirl, strict=True)
        if whirl not in ("rigid", "torsion", "axial") and frequency > 0.0
    ]
    if not lateral:
        return ""
    ratios = ratios_by_shaft(model.base)
    fastest = max(abs(ratios[channel.reference]) for channel in model.channels)
    share = float(np.abs(model.speeds).max()) * fastest / (2.0 * np.pi * lateral[0])
    if share > _LOW_SPEED:
        return ""
    return (
        f", because no speed is above {share:.2g} of the first natural frequency of "
        f"{lateral[0]:.4g} Hz"
    )
