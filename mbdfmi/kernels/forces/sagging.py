"""Lines that come under the sea's bed where none lies on it: told once of each in a run (docs/theory.md 16.15).

A line has a bed only where its first end is on one. What hangs between two bodies, or from a place over the bed, knows nothing of it.
"""

from ..language import apart, inlined, kernel
from ..motion import kinematics, markers
from ..signatures import DATA, MODEL, void
from ..status import UNDER_BED, status, tell
from . import catenaries, composite_lines
from .composite_shapes import bottom, last_section, least_pull, weight
from .line_pieces import piece

TOLD = 1.0

# of the depth: how far under the bed is still on it
ON_BED = 1.01


@kernel
def lowest(m, d, k):
    """z (m) to which line k comes down, of one that lies on a bed that of its lower end."""
    now = catenaries.line(m, d, k)
    z = markers.position(m, d, now.lower)[2]

    if m.line_bed[k] == 1:
        return min(z, markers.position(m, d, now.upper)[2])

    w = catenaries.weight(m, k)
    L = m.line_length[k]
    sags = w * L - now.V

    if sags <= 0.0:
        return z

    # from where it is level to the lower end
    return z - piece(w, sags / w, m.line_stiffness[k], max(now.H, 1e-14 * w * L), sags, 0.0).z


@kernel
def lowest_composite(m, d, k):
    """The same of line k of those of several sections, along them from the second end."""
    now, _, _ = composite_lines.line(m, d, k)
    z = markers.position(m, d, m.composite_to[k])[2]
    least = min(z, markers.position(m, d, m.composite_from[k])[2])

    if m.composite_bed[k] == 1:
        return least

    H = max(now.H, least_pull(d, k))

    for i in range(last_section(m, k), m.composite_section[k] - 1, -1):
        w = weight(m, i)
        EA = m.section_stiffness[i]
        top = now.V - d.section_top[i]
        end = now.V - bottom(m, d, i)

        if top > 0.0 and end < 0.0:
            least = min(least, z - piece(w, top / w, EA, H, top, 0.0).z)

        z -= piece(w, m.section_length[i], EA, H, top, end).z
        least = min(least, z)

    return least


@apart(void(MODEL, DATA))
def tell_low(m, d):
    """A notice of each line that is under the bed for the first time."""
    kinematics.kinematics(m, d)

    for j in range(m.n_low):
        if d.low_told[j] == TOLD:
            continue

        k = m.low_line[j]
        z = lowest_composite(m, d, k) if m.low_composite[j] == 1 else lowest(m, d, k)

        if z < ON_BED * m.low_bed[j]:
            d.low_told[j] = TOLD
            tell(d, status(UNDER_BED, m.low_place[j]), z, m.low_bed[j])


@inlined
def reset(m, d):
    """At the start nothing was told."""
    for j in range(m.n_low):
        d.low_told[j] = 0.0


@inlined
def all_told(m, d):
    """Whether there is nothing left to tell."""
    for j in range(m.n_low):
        if d.low_told[j] != TOLD:
            return False

    return True
