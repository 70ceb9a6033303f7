"""What there is to tell of a start: given values that could not be kept, gaps taken, what is stuck or beyond a stop."""

from . import joints
from .dynamics import rows
from .dynamics.projection import gap_of
from .language import inlined, kernel
from .math import algebra as al
from .motion import coordinates, markers
from .status import (
    BEYOND_STOP,
    BODY_STUCK,
    COUPLING_OFF,
    COUPLING_OPEN,
    GAP_TAKEN,
    LOOP_ALONG,
    LOOP_ALONG_Z,
    LOOP_HELP,
    LOOP_OPEN,
    LOOP_SIZE,
    SINGULAR_START,
    START_MOVED,
    START_TURNED,
    status,
    tell,
)

# kinds of start values; told_at
POSITION = 0  # of a joint of one coordinate: its node
SPEED = 1
PLACE = 2  # of a spherical or free joint, component by component: its node
ORIENTATION = 3
VELOCITY = 4
OMEGA = 5
COORDINATE = 6  # of a joint that closes a loop: its coordinate
RATE = 7
PARAMETER = 8  # of a contact: its parameter
MARKER_PLACE = 9  # of a spherical or free joint that closes a loop: its first marker
MARKER_ORIENTATION = 10
MARKER_VELOCITY = 11
MARKER_OMEGA = 12
MARKER_OMEGA_BODY = 13

# what is off by less, relative to 1 plus the value, is as given
AS_GIVEN = 1e-9

# a loop open by less (m, rad) is singular: rows are dropped there
SINGULAR = 1e-6

# rad, of an orientation
AS_TURNED = 1e-8


@inlined
def closing_value(m, d, k):
    """What is taken of a joint that closes a loop, SI; of an orientation how far it was turned."""
    kind = m.told_kind[k]
    a = m.told_at[k]
    b = m.told_to[k]
    component = m.told_component[k]

    if kind == COORDINATE:
        return coordinates.value(m, d, a)

    if kind == RATE:
        return coordinates.rate(m, d, a)

    if kind == MARKER_PLACE:
        return markers.relative_position(m, d, a, b)[component]

    if kind == MARKER_VELOCITY:
        return markers.relative_velocity(m, d, a, b)[component]

    A = markers.relative_axes(m, d, a, b)

    if kind == MARKER_ORIENTATION:
        return joints.turn_between(al.E_at(m.told_value, 4 * k), al.matrix_E(A))

    w = markers.relative_angular_velocity(m, d, a, b)

    if kind == MARKER_OMEGA_BODY:
        w = al.matT_vec(A, w)

    return w[component]


@inlined
def values(m, d, k):
    """(given, taken) of start value k, SI; of an orientation 0 and how far it was turned."""
    kind = m.told_kind[k]
    at = m.told_at[k]
    component = m.told_component[k]

    if kind == POSITION:
        return m.q_start[m.body_q[at]], d.q[m.body_q[at]]

    if kind == SPEED:
        return m.v_start[m.body_v[at]], d.v[m.body_v[at]]

    if kind == PARAMETER:
        return m.s_start[at], d.z[at]

    if kind >= COORDINATE:
        return m.told_value[4 * k], closing_value(m, d, k)

    r, E, rd, w = joints.told_start(m, at)
    r_now, E_now, rd_now, w_now = joints.told_motion(m, d, at)

    if kind == PLACE:
        return r[component], r_now[component]

    if kind == ORIENTATION:
        return 0.0, joints.turn_between(E, E_now)

    if kind == VELOCITY:
        return rd[component], rd_now[component]

    return w[component], w_now[component]


@inlined
def tell_start(m, d, k):
    """Start value k where it was not kept."""
    given, taken = values(m, d, k)
    unit = m.told_unit[k]

    if m.told_kind[k] == ORIENTATION or m.told_kind[k] == MARKER_ORIENTATION:
        if taken > AS_TURNED:
            tell(d, status(START_TURNED, m.told_place[k]), taken * unit, 0.0)

    elif not abs(taken - given) <= AS_GIVEN * (1.0 + abs(given)):
        tell(d, status(START_MOVED, m.told_place[k]), given * unit, taken * unit)


@inlined
def tell_stop(m, d, k):
    """A joint that starts beyond its stop."""
    position = coordinates.value(m, d, m.stop_coordinate[k])
    unit = m.stop_unit[k]

    if position < m.stop_lower[k]:
        tell(d, status(BEYOND_STOP, m.stop_place[k]), position * unit, m.stop_lower[k] * unit)
    elif position > m.stop_upper[k]:
        tell(d, status(BEYOND_STOP, m.stop_place[k]), position * unit, m.stop_upper[k] * unit)


@kernel
def tell_of_start(m, d):
    """All there is to tell of a start that stands; needs rows and what assembly left."""
    for k in range(m.n_stop):
        tell_stop(m, d, k)

    for c in range(m.n_constraint):
        if d.loose[0] > 0.0:
            span, turned = gap_of(m, d, c, True)

            if max(al.norm(span), turned) > m.closing_tolerance[0]:
                tell(d, status(GAP_TAKEN, m.n_body + c), al.norm(span), turned)

    # a node without a body, inside a chain of simple motions, may well stand still; one with several bodies is told once
    for k in range(m.n_solid):
        i = m.solid_body[k]

        if d.stuck[i] == 2.0:
            d.stuck[i] = 0.0
            tell(d, status(BODY_STUCK, i), 0.0, 0.0)

    # these may be many: what does not fit any more is of their kind
    for k in range(m.n_told):
        tell_start(m, d, k)


@kernel
def tell_open(m, d, failure):
    """How a loop stands that cannot be closed; returns the status to fail with. Needs rows."""
    if failure % 256 != LOOP_OPEN:
        return failure

    c = failure // 256 - m.n_body
    span, turned = gap_of(m, d, c, False)
    size = al.norm(span)

    row = m.constraint_row[c]

    if m.row_kind[row] == rows.COUPLING and m.row_drive[row] < 0 and turned > SINGULAR:
        tell(d, status(COUPLING_OFF, m.n_body + c), turned, 0.0)
        tell(d, status(LOOP_HELP, m.n_body + m.n_constraint + c), 0.0, 0.0)
        return status(COUPLING_OPEN, m.n_body + c)

    tell(d, status(LOOP_SIZE, m.n_body + c), size, turned)

    if size > 0.0:
        tell(d, status(LOOP_ALONG, m.n_body + c), span[0], span[1])
        tell(d, status(LOOP_ALONG_Z, 0), span[2], 0.0)

    if size <= SINGULAR and turned <= SINGULAR:
        return status(SINGULAR_START, m.n_body + c)

    tell(d, status(LOOP_HELP, m.n_body + m.n_constraint + c), 0.0, 0.0)
    return failure
