"""Masses of links as a scene takes them."""

import numpy as np

from ..bodies import MOMENTS_ROUNDED, inertia_matrix, principal_moments
from ..errors import quoted

# as far as the scene's own check takes a moment for zero
ROUNDING = 1e-9


def mass_keys(link):
    """(keys of a body, what was changed in words or None, what is odd and was kept or None) of a link."""
    keys = {"mass": link.mass}
    xyz, rpy = link.origin

    if any(xyz):
        keys["com"] = list(xyz)
    if link.massless:
        return keys, None, None

    inertia, changed = _possible(link)
    keys["inertia"] = list(inertia[:3]) if not any(inertia[3:]) else list(inertia)

    if any(rpy) and any(inertia):
        keys["inertia_axes"] = {"zyx_rad": list(rpy[::-1])}

    return keys, changed, None if changed else _odd(link)


def _odd(link):
    """That no body has the moments of a link, in words, or None."""
    moments = np.linalg.eigvalsh(inertia_matrix(link.inertia))
    if moments[0] + moments[1] >= moments[2] * (1 - MOMENTS_ROUNDED):
        return None
    return f"no body has such moments, one exceeds the sum of the others; kept: {principal_moments(moments)}"


def _possible(link):
    """The inertia of a link, with negative principal moments raised to zero, and what was changed or None.

    Moments that no body has because one exceeds the sum of the others are kept: they simulate, and a notice tells.
    """
    I = inertia_matrix(link.inertia)
    moments, axes = np.linalg.eigh(I)

    if moments[0] >= -ROUNDING * np.abs(I).max():
        return link.inertia, None

    raised = axes @ np.diag(np.maximum(moments, 0.0)) @ axes.T
    text = (
        f"{quoted(link.name)} has a negative principal moment of inertia, which no body has and no run survives: "
        f"raised to 0; {principal_moments(moments)}"
    )
    return tuple(float(raised[at]) for at in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))), text
