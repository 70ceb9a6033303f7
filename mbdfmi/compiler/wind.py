"""Wind, and rotors in it."""

import numpy as np

from ..kernels import outputs
from ..kernels.math.tables import HOLD
from ..lazily import scipy
from ..scene import Problem, SceneError
from ..vectors import norm, spline_at
from ..vocabulary import ROTOR_OUTPUTS, ROTOR_PITCH, WIND_VELOCITY
from .builder import Place, Source
from .interpolation import curve, quintic_through
from .sea_limits import tell_wet_blades
from .variables import dotted

# words of the scene -> kinds of kernels/outputs.py
ROTOR_KINDS = {
    "thrust": outputs.ROTOR_THRUST,
    "torque": outputs.ROTOR_TORQUE,
    "wind": outputs.ROTOR_WIND,
    "power": outputs.ROTOR_POWER,
}

# of the table: cells for each step between its points, at most
FINER = 2
MOST_CELLS = 60

# of a gust: 1e-9 of its size; an odd number, so that no knot is where it turns
PIECES = 65

# sin(3 x) (1 - cos(2 x)) by the sines of multiples of x
EOG = {1: -0.5, 3: 1.0, 5: -0.5}

# values and slopes at the ends of a unit interval to the coefficients of the cubic between
HERMITE = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [-3, 3, -2, -1], [2, -2, 1, 1]])


def add_rotor(builder, name, force, ends):
    """A rotor in the wind. Raises SceneError for a table that cannot be read."""
    spec, tables = force.rotor, builder.tables
    path = ("force", name, "rotor", "table")
    wind, nodes = builder.scene.wind, [builder.node_of(force.on)]
    first_wind = _wind_input(builder)
    u = -1

    if force.input:
        about = f"pitch of the blades of {name}"
        u = builder.add_inputs(dotted(name, "pitch"), ROTOR_PITCH, about, nodes, start=spec.pitch)

    if first_wind >= 0:
        for given in builder.inputs[first_wind : first_wind + 3]:
            given.nodes.update(set(nodes) - {0})

    try:
        grid, cells = _cells(*spec.grid())
    except ValueError as error:
        raise SceneError([Problem(path, str(error))]) from None

    first = tables["n_cell"].length

    for c in cells.reshape(-1, 32):
        tables["n_cell"].add(cell_c=c)

    row = tables["n_wind_rotor"].add(
        wind_rotor_marker=ends[0],
        wind_rotor_u=u,
        rotor_cell=first,
        rotor_cells=cells.shape[:2],
        wind_rotor_value=[spec.radius, wind.density, spec.pitch],
        rotor_grid=grid,
    )

    if not force.input:
        place = Place("wind_rotor_value", row, 2)
        builder.add_parameters(
            dotted(name, "pitch"), place, spec.pitch, "rad", f"pitch of the blades of {name}"
        )

    tell_wet_blades(builder, name, force)
    fed_by = [] if u < 0 else [u]
    fed_by += [first_wind + k for k in range(3)] if first_wind >= 0 else []

    for output in force.output:
        quantity = ROTOR_OUTPUTS[output]
        source = Source(ROTOR_KINDS[output], row)
        builder.add_outputs(
            dotted(name, output), source, quantity.unit, f"{name}: {quantity.text}", nodes, fed_by
        )


def _wind_input(builder):
    """The first input that tells the wind's velocity, -1: none; the wind is added by its first rotor."""
    wind, table = builder.scene.wind, builder.tables["n_wind"]

    if not table.length:
        steady, u = wind.steady, -1

        if wind.input:
            about = "velocity of the wind at the reference height"
            u = builder.add_inputs("wind.velocity", WIND_VELOCITY, about, (), start=steady.velocity)

        table.add(
            wind_u=u, wind_velocity=steady.velocity, wind_profile=[steady.exponent, steady.reference_height]
        )

        _add_gust(builder)

        if u < 0:
            about = "velocity of the wind at the reference height"
            builder.add_parameters("wind.velocity", Place("wind_velocity"), steady.velocity, "m/s", about)

    return int(table.columns["wind_u"][0][0])


def _add_gust(builder):
    """What is added to the wind over time, as tables."""
    wind, gust = builder.scene.wind, builder.scene.wind.gust

    if gust is None:
        return

    if gust.table:
        time, velocity = np.array(gust.table.time), np.array(gust.table.velocity)
        first = builder.tables_over_time(gust.table.interpolation, time, velocity)
    else:
        steady = np.array(wind.steady.velocity)
        piece, way = _eog(gust.eog, steady, wind.steady.reference_height) if gust.eog else _step(gust.step)
        first, *_ = [builder.table(_times(part, piece), HOLD) for part in way]

    builder.tables["n_gust"].add(gust_table=first)


def _eog(spec, steady, height):
    """(speed over time, direction) of an extreme operating gust: -0.37 a sin(3 x)(1 - cos(2 x)) is a sum of sin(x), sin(3 x), sin(5 x)."""
    speed = norm(steady)
    x = np.linspace(0.0, np.pi, PIECES + 1)
    rate = np.pi / spec.period
    y, slope, bend = (
        -0.37 * spec.size(speed, height) * sum(part * rate**n * k**n * f(k * x) for k, part in EOG.items())
        for n, f in enumerate((np.sin, np.cos, lambda u: -np.sin(u)))
    )
    # it begins and ends smoothly, but for rounding
    for values in (y, slope, bend):
        values[[0, -1]] = 0.0

    return quintic_through(spec.start + x / rate, y, slope, bend), steady / speed


def _step(spec):
    """(part of the change over time, the change)."""
    if spec.rise == 0.0:
        return curve("steps", [spec.start - 1.0, spec.start], [0.0, 1.0]), np.array(spec.velocity)

    x = np.linspace(0.0, np.pi, PIECES + 1)
    rate = np.pi / spec.rise
    y, slope, bend = (1.0 - np.cos(x)) / 2, rate * np.sin(x) / 2, rate**2 * np.cos(x) / 2
    slope[-1] = 0.0
    return quintic_through(spec.start + x / rate, y, slope, bend), np.array(spec.velocity)


def _times(factor, piece):
    """A piecewise polynomial times a number."""
    return scipy.interpolate.PPoly(factor * piece.c, piece.x)


def _cells(ratio, pitch, thrust, torque):
    """([first ratio, step, first pitch, step], (n, k, 2, 16)) of tables as bicubic cells of equal size."""
    axes = [np.linspace(x[0], x[-1], 1 + min(MOST_CELLS, FINER * (len(x) - 1))) for x in (ratio, pitch)]
    steps = [axis[1] - axis[0] for axis in axes]
    found = []

    for table in (thrust, torque):
        along = spline_at(ratio, table, axes[0])
        parts = [spline_at(pitch, part, axes[1], axis=1) for part in along]
        f = np.array([[parts[i][j] * steps[0] ** i * steps[1] ** j for j in (0, 1)] for i in (0, 1)])

        # corners of each cell: values along (s = 0, 1; slopes at 0, 1) by (t likewise)
        rows = [f[0, :, :-1], f[0, :, 1:], f[1, :, :-1], f[1, :, 1:]]
        corner = np.array([[r[0, :, :-1], r[0, :, 1:], r[1, :, :-1], r[1, :, 1:]] for r in rows])
        found.append(np.einsum("ia,abnk,jb->nkij", HERMITE, corner, HERMITE))

    cells = np.stack(found, axis=2)
    return [axes[0][0], steps[0], axes[1][0], steps[1]], cells.reshape(*cells.shape[:3], 16)
