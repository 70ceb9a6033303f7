"""What is told as soon as a motion has come there: ends of curves and surfaces that a joint holds axes to, lines under the sea's bed.

Beyond an end curves and surfaces are straight, and the axes stop turning at once.

That takes energy from a body, or gives it some, which no law of mechanics allows (docs/theory.md 10.5): so it is told, once of
each joint in a run. Whether it was is kept where the side of surfaces that touch is, of which these joints know none.
"""

from ..end_frames import curves, surfaces
from ..end_frames.touching import ON_CURVE
from ..forces import sagging
from ..language import apart, inlined, kernel
from ..math import algebra as al
from ..math import tables
from ..signatures import DATA, MODEL, int64, void
from ..status import BEYOND_END, OK, status, tell
from . import rows

TOLD = 1.0

# rad, by what the whole of a curve would turn if it were bent as at its end: less is straight
STRAIGHT = 1e-6

# of a table of points, beside an edge: the patch there is that which ends at it
INSIDE = 1e-9


@inlined
def turns(m, table, t, tt):
    """Whether a curve of these derivatives by its parameter, that of the table, is bent."""
    span = tables.last(m, table) - tables.first(m, table)
    return al.norm(al.cross(t, tt)) * span > STRAIGHT * al.dot(t, t)


@inlined
def end_of_curve(m, k, s):
    """(s, the end of curve k that it lies beyond, whether the curve is bent there); s twice where it lies beyond none."""
    end = curves.nearest(m, k, s)
    _, t, tt = curves.point(m, k, end)
    return s, end, s != end and turns(m, m.curve_table[k], t, tt)


@kernel
def end_of(m, d, k):
    """`end_of_curve` of the first parameter of end frame k that leads beyond one."""
    s = d.z[m.end_frame_z[k]]
    shape = m.end_frame_from[k]

    if m.end_frame_kind[k] == ON_CURVE:
        return end_of_curve(m, shape, s)

    if m.surface_kind[shape] == surfaces.PRISM:
        return end_of_curve(m, m.surface_curve[shape], s)

    if m.surface_kind[shape] != surfaces.TABLE:
        return s, s, False

    s2 = d.z[m.end_frame_z[k] + 1]
    one = m.surface_table[2 * shape]
    two = m.surface_table[2 * shape + 1]
    end1 = surfaces.within_edges(m, one, s, 0.0)
    end2 = surfaces.within_edges(m, two, s2, 0.0)
    inside1 = surfaces.within_edges(m, one, s, INSIDE)
    _, r1, r2, r11, _, r22 = surfaces.point(m, shape, inside1, surfaces.within_edges(m, two, s2, INSIDE))

    if s != end1 and turns(m, one, r1, r11):
        return s, end1, True

    return s2, end2, s2 != end2 and turns(m, two, r2, r22)


@apart(void(MODEL, DATA))
def tell_ends(m, d):
    """A notice of each joint whose frame is beyond an end for the first time, where that is and where it is now."""
    for row in range(m.n_row):
        k = m.row_j[row]

        if m.row_kind[row] != rows.FRAME or m.row_i[row] != 0 or d.end_frame_side[k] == TOLD:
            continue

        s, end, bent = end_of(m, d, k)

        if bent:
            d.end_frame_side[k] = TOLD
            tell(d, status(BEYOND_END, m.n_body + m.row_constraint[row]), s, end)


@inlined
def see_ends(m, d):
    """`tell_ends`, and of lines, in a state that the motion really comes to: no stepper takes it back."""
    if m.n_end_frame > 0:
        tell_ends(m, d)

    if m.n_low > 0 and not sagging.all_told(m, d):
        sagging.tell_low(m, d)


@apart(int64(MODEL, DATA), "mbdfmi_complete")
def complete(m, d):
    """The same of a state that an integrator outside has come to. Returns OK."""
    see_ends(m, d)
    return OK
