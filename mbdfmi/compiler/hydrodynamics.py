"""Bodies that linear potential theory knows."""

import contextlib
import hashlib
import zipfile
from functools import lru_cache
from pathlib import Path

import numpy as np

from ..files import replacing
from ..hydro import memory as memory_module
from ..hydro.consistency import disagreements, told_spikes, without_spikes
from ..hydro.database import around
from ..hydro.memory import Memory, fit
from ..hydro.progress import Progress
from ..hydro.reading import read_coefficients, read_states
from ..kernels import entry, layout, outputs
from ..kernels.forces.six_by_six import BODY, FIRST, HEADING
from ..kernels.motion import markers
from ..kernels.status import OK
from ..native.sources import cache_directory
from ..scene import Problem, SceneError
from ..scene.sea import Sea
from ..vocabulary import EXCITATION_FORCE, EXCITATION_MOMENT, HYDRODYNAMICS_OUTPUTS
from .afloat import tell_other_waterplane
from .builder import Source
from .natural import Fitted
from .resistance import add_resistance
from .seas import add_waves, sea_components
from .start import start_pose
from .variables import dotted

# words of the scene -> kinds of kernels/outputs.py, of radiation, excitation and damping
HYDRODYNAMICS_KINDS = {
    "radiation_force": (outputs.RADIATION_FORCE, 0),
    "radiation_moment": (outputs.RADIATION_MOMENT, 0),
    "radiation_power": (outputs.RADIATION_POWER, 0),
    "excitation_force": (outputs.EXCITATION_FORCE, 1),
    "excitation_moment": (outputs.EXCITATION_MOMENT, 1),
    "excitation_power": (outputs.EXCITATION_POWER, 1),
    "damping_force": (outputs.RESISTANCE_FORCE, 2),
    "damping_moment": (outputs.RESISTANCE_MOMENT, 2),
    "damping_power": (outputs.RESISTANCE_POWER, 2),
}

# words of the scene -> axes of forces/water_axes.py
AXES = {"first": FIRST, "heading": HEADING, "body": BODY}

# part of the energy outside a file's frequencies that is told
OUTSIDE = 0.01

# rad, by which a direction may be beyond a file's last one
BESIDE = 1e-6
# data of a file, and what is taken outside its frequencies
EXCITATION = ("excitation", "the nearest of its frequencies is taken")
RADIATION = (
    "radiation",
    "damping is taken to fall, with the square of frequency below and its third power above",
)

# of a memory's peaks, where the scene asks for nothing else; from which on a number of states that it asks for is told to be few
ERROR = 0.01
COARSE = 0.1


def add_hydrodynamics(builder, name, force, ends):
    """Added mass, memory, excitation of bodies. Raises SceneError for files that cannot be read."""
    spec, sea = force.hydrodynamics, builder.scene.sea or Sea()
    ends, starts = _points(builder, force, ends)
    axes = AXES[spec.axes]
    path = ("force", name, "hydrodynamics", "file")
    told = _memory_told(spec)

    # of bodies of one file: where they are, for their phases are told of its origin
    several = len(starts) > 1 or spec.bodies
    places = tuple((float(r[0]), float(r[1])) for r in starts) if several else ()

    try:
        stamp = spec.file.path.stat().st_mtime_ns
        water = (
            sea.density,
            -builder.scene.gravity[2],
            sea.depth,
            spec.scale,
            spec.froude,
            spec.spikes == "cut",
        )
        coefficients, notes, memory, held = _read(
            str(spec.file.path),
            stamp,
            *water,
            told,
            spec.bodies,
            len(ends),
            builder.near.get(name, ()),
            places,
        )
    except OSError as error:
        text = f"cannot read {error.filename or spec.file.path}: {error.strerror or error}"
        raise SceneError([Problem(path, text)]) from None
    except ValueError as error:
        raise SceneError([Problem(path, str(error))]) from None

    for note in notes:
        builder.notice(path, note)

    infinite = memory.infinite if memory else coefficients.infinite

    if memory and told[0] < memory.error and not (told[1] or told[2]):
        text = (
            f"the memory of {len(memory.pole)} states misses {100 * memory.error:.2g} % of a peak, not {100 * told[0]:.2g} %; it gets no "
            "more states than that"
        )
        builder.notice(("force", name, "hydrodynamics", "radiation"), text)
    elif memory and told[1] and memory.error > COARSE:
        text = (
            f"the memory of states = {told[1]} misses {100 * memory.error:.2g} % of a peak; each motion that makes waves of its own "
            "takes 2 or more: give more, or the error that it may have"
        )
        builder.notice(("force", name, "hydrodynamics", "radiation"), text)

    if memory and not (told[1] or told[2]):
        builder.fitted[name] = Fitted(ends, coefficients, memory)

    if infinite is None:
        text = "has no added mass at infinite frequency; leave out radiation = false, for the memory finds it"
        raise SceneError([Problem(path, text)])

    for k, end in enumerate(ends):
        own = slice(6 * k, 6 * k + 6)
        add_added_mass(builder, end, infinite[own, own], axes)

    _add_shared_water(builder, ends, infinite)
    _check_axes(path, spec.axes, held)
    rows = [_add_memory(builder, name, ends, memory, infinite, axes), [-1] * len(ends)]
    rows.append(add_resistance(builder, name, force, ends, axes))

    if sea.waves and memory and not told[2]:
        _tell_outside(builder, path, sea_components(builder.scene), coefficients.omega, RADIATION)

    tell_other_waterplane(builder, name, force, coefficients)

    if spec.excitation == "input":
        _add_excitation_inputs(builder, name, force, ends)

        if sea.waves:
            text = 'is "input": the waves of [sea] do not act here, what comes in does'
            builder.notice(("force", name, "hydrodynamics", "excitation"), text)
    elif spec.excitation and sea.waves:
        _check_loads_turn(path, spec.axes, coefficients)
        rows[1] = _add_excitation(
            builder, name, (ends, starts), coefficients, held == 1, spec.position == "now", axes
        )

    _add_outputs(builder, name, force, rows)


def _points(builder, force, ends):
    """(markers, where they start (m)) of the points that coefficients are about, at the ends unless the scene has others."""
    starts = [start_pose(builder, end) for end in force.between]
    places = force.hydrodynamics.places()

    if not places:
        return ends, [r for r, _ in starts]

    found = []

    for end, place in zip(force.between, places):
        node, (r, A) = builder.tree.marker(builder.scene, end)
        found.append(builder.add_marker((end, tuple(place)), node, (r + A @ place, A)))

    return found, [r + A @ place for (r, A), place in zip(starts, places)]


def _check_axes(path, axes, held):
    """Raises SceneError where bodies that are solved together are to turn, each with what it says of the others."""
    if axes != "first" and held > 1:
        text = (
            f'axes = "{axes}" is of one body that turns; the file holds {held}, and what it says of the water between them is of bodies that '
            'keep their headings: axes = "first", or a file of each body alone'
        )
        raise SceneError([Problem((*path[:-1], "axes"), text)])


def _check_loads_turn(path, axes, coefficients):
    """Raises SceneError where a body would turn to where its file has no loads of waves."""
    if axes == "body":
        text = (
            'axes = "body" turns all with a body at any angle, and the file has loads of waves on one that is upright: excitation = false or '
            '"input", or axes = "heading"'
        )
        raise SceneError([Problem((*path[:-1], "axes"), text)])

    if axes == "heading" and coefficients.headings is not None:
        known = around(coefficients.headings, coefficients.excitation)[0]

        if known[-1] - known[0] < 2 * np.pi - BESIDE:
            text = (
                f'axes = "heading" lets the body turn to any heading; those of the file are from {np.degrees(known[0]):.4g} to '
                f"{np.degrees(known[-1]):.4g} degrees: solve it for all, as with mbdfmi hydro --heading 0:330:30"
            )
            raise SceneError([Problem((*path[:-1], "axes"), text)])


def _parts(name, force):
    """For each end the parts of its variables' names: of several bodies each has its own."""
    bodies = [end.split(".")[0] for end in force.between]
    return [(name,) if len(bodies) == 1 else (name, body) for body in bodies]


def _add_shared_water(builder, ends, infinite):
    """Added mass between bodies, for each pair that moves; what is fixed to the ground bears what the ground does."""
    moving = [k for k, end in enumerate(ends) if builder.marker_node(end) > 0]

    for j, b in enumerate(moving):
        for a in moving[:j]:
            builder.tables["n_shared_water"].add(
                shared_from=ends[a],
                shared_to=ends[b],
                shared_added=infinite[6 * b : 6 * b + 6, 6 * a : 6 * a + 6],
            )

    if len(moving) > 1:
        builder.shared_nodes.append([builder.marker_node(ends[k]) for k in moving])


def add_added_mass(builder, marker, added, axes=FIRST):
    """Added mass (6, 6) about a marker, in the axes of the inertial frame whatever way its body turns, or others. Returns its row."""
    return builder.tables["n_six_by_six"].add(
        six_by_six_from=builder.marker("inertial"),
        six_by_six_to=marker,
        six_by_six_adds=builder.marker_node(marker) > 0,
        six_by_six_axes=axes,
        six_by_six_stiffness=np.zeros((6, 6)),
        six_by_six_damping=np.zeros((6, 6)),
        six_by_six_added=added,
        six_by_six_preload=np.zeros(6),
    )


def _memory_told(spec):
    """(error, states, file) of the memory, None: none."""
    if spec.radiation is False:
        return None
    if spec.radiation is True:
        return ERROR, None, None

    file = spec.radiation.file
    return spec.radiation.error or ERROR, spec.radiation.states, str(file.path) if file else None


@lru_cache(maxsize=8)
def _read(path, stamp, density, gravity, depth, scale, froude, cut, told, bodies, count, near, places):
    """(coefficients, notes, memory or None) of some bodies of a file, and how many that has; stamp : a changed file is read anew.

    bodies : their numbers from 1, None: all. count : of the ends that they are to have. near : what the memory is to meet beside.
    places : (x, y) m of several, where they start. Raises ValueError.
    """
    found = read_coefficients(path, density, gravity, scale)
    found = found.enlarged(froude) if froude != 1.0 else found
    _check_bodies(path, found.bodies, bodies, count)
    coefficients, notes = (found.of(bodies) if bodies else found).checked()
    coefficients, cuts = without_spikes(coefficients) if cut else (coefficients, told_spikes(coefficients))
    notes = (
        notes
        + cuts
        + disagreements(coefficients, density, gravity, depth, places if found.bodies > 1 else ())
    )

    if coefficients.bodies < found.bodies:
        notes = [
            f"holds {found.bodies} bodies; those that are not in `bodies` are as if held still where they are",
            *notes,
        ]

    if told is None:
        return coefficients, notes, None, found.bodies

    error, states, file = told

    if file is None:
        return coefficients, notes, _kept_fit(coefficients, error, states, near), found.bodies
    if coefficients.infinite is None:
        raise ValueError(
            f"{path}: has no added mass at infinite frequency, which a ready model of radiation needs"
        )
    if count > 1:
        raise ValueError(f"{file}: is of one body; of several the memory is fitted: leave out radiation")
    return coefficients, notes, read_states(file, coefficients.infinite), found.bodies


def _check_bodies(path, held, bodies, count):
    """Raises ValueError where the bodies of a file are not those that are asked for."""
    if bodies and max(bodies) > held:
        raise ValueError(f"{path}: holds {held} bod{'y' if held == 1 else 'ies'}; there is no {max(bodies)}")
    if bodies and len(bodies) != count:
        raise ValueError(f"{path}: `on` names {count} ends, `bodies` {len(bodies)}; one for each")
    if not bodies and held != count:
        ends = "an end for each, as in on = [" + ", ".join(f'"body_{k + 1}"' for k in range(held)) + "]"
        what = "one end" if held == 1 else ends + ", or those that are meant, as in bodies = [1]"
        raise ValueError(
            f"{path}: holds {held} bod{'y' if held == 1 else 'ies'}, `on` names {count}; needs {what}"
        )


def _kept_fit(coefficients, error, states, near):
    """The fit of a body, kept in the cache folder under a hash of all that it is made of."""
    given = [coefficients.omega, coefficients.added, coefficients.damping, coefficients.infinite]
    digest = hashlib.sha256(
        f"{error} {states} {near or ''}".encode() + Path(memory_module.__file__).read_bytes()
    )

    for array in given:
        digest.update(b"none" if array is None else np.ascontiguousarray(array, "<f8").tobytes())

    path = cache_directory() / "memory" / f"{digest.hexdigest()[:24]}.npz"

    try:
        with np.load(path, allow_pickle=False) as found:
            arrays = [found[name] for name in ("pole", "mate", "source", "sink", "infinite")]
            return Memory(*arrays, float(found["error"]), [])
    except (OSError, ValueError, KeyError, zipfile.BadZipFile):
        with Progress.shown("fitting the memory of waves") as tell:
            memory = fit(coefficients, error, states, tell, near)

    # where nothing can be kept it is fitted again the next time
    with contextlib.suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)

        with replacing(path) as temporary, open(temporary, "wb") as file:
            np.savez(
                file, pole=memory.pole, mate=memory.mate, source=memory.source, sink=memory.sink,
                infinite=memory.infinite, error=memory.error,
            )  # fmt: skip

    return memory


def _add_memory(builder, name, ends, memory, infinite, axes):
    """Rows of the memory of markers' bodies, which share its states; -1 without."""
    if memory is None or not len(memory.pole):
        return [-1] * len(ends)

    tables = builder.tables
    first = tables["n_memory"].length

    # states in units in which each makes an acceleration of the body's own added mass: errors are weighed by that
    inertia = np.where(np.diag(infinite) > 0, np.diag(infinite), np.diag(infinite).max())
    pull = np.abs(memory.sink / inertia).max(axis=1)
    pull = np.maximum(pull, pull[memory.mate])
    pull = np.where(pull > 0.0, pull, 1.0)

    for mate, pole in zip(memory.mate, memory.pole):
        tables["n_memory"].add(memory_mate=first + mate, memory_pole=pole)

    rows = []

    for i, marker in enumerate(ends):
        begin, own = tables["n_memory_row"].length, slice(6 * i, 6 * i + 6)

        for k in range(len(memory.pole)):
            tables["n_memory_row"].add(
                memory_from=memory.source[k, own] * pull[k], memory_to=memory.sink[k, own] / pull[k]
            )

        builder.radiations.append(name)
        rows.append(
            tables["n_radiation"].add(
                radiation_marker=marker,
                radiation_memory=first,
                radiation_memories=len(memory.pole),
                radiation_row=begin,
                radiation_axes=axes,
            )
        )

    return rows


def _add_excitation(builder, name, places, coefficients, alone, follows, axes):
    """Rows of what the sea's waves do to markers' bodies, of one that is alone in its file about where it starts, of others where
    the file has them.

    places : markers, and where they start (m). follows : whether waves meet them where they are. axes : of the loads, not BODY.
    """
    add_waves(builder)
    tables, path = builder.tables, ("force", name, "hydrodynamics", "file")
    waves = sea_components(builder.scene)

    try:
        omega, headings, points = coefficients.grid
    except ValueError as error:
        raise SceneError([Problem(path, str(error))]) from None

    _check_headings(path, headings, waves.heading)
    _tell_outside(builder, path, waves, omega, EXCITATION)
    first, rows = tables["n_grid"].length, []

    for value in (*omega, *headings):
        tables["n_grid"].add(grid_value=value)

    for k, (marker, start) in enumerate(zip(*places)):
        first_point = tables["n_response_point"].length

        for point in points[:, :, k].reshape(-1, 48):
            tables["n_response_point"].add(point_force=point)

        builder.counts["n_part"] = builder.counts.get("n_part", 0) + len(waves.omega)
        turned = builder.counts.get("n_heading_part", 0)

        if axes != FIRST:
            builder.counts["n_heading_part"] = turned + len(waves.omega) * len(headings)
        row = tables["n_excitation"].add(
            excitation_marker=marker,
            excitation_grid=[first, len(omega), len(headings), first_point],
            excitation_turns=turned if axes != FIRST else -1,
            excitation_place=start[:2] if alone else [0.0, 0.0],
        )
        rows.append(row)
        _add_following(builder, row, follows, start)

        if alone:
            builder.wave_places.append(("excitation_place", row, 2, (marker,), 0.0))
        if follows:
            builder.wave_places.append(("follow_place", row, 2, (marker,), 0.0))

    return rows


def _add_following(builder, row, follows, start):
    """Whether waves meet an element where it is: told of each, once it is so of one."""
    table = builder.tables["n_follow"]

    if follows or table.length:
        while table.length < row:
            table.add(excitation_follows=0, follow_place=[0.0, 0.0])

        table.add(excitation_follows=int(follows), follow_place=start[:2])


def _add_excitation_inputs(builder, name, force, ends):
    """What a sea from elsewhere does to markers' bodies, as inputs."""
    for marker, end, parts in zip(ends, force.between, _parts(name, force)):
        nodes, first = [builder.node_of(end)], {}

        for quantity in (EXCITATION_FORCE, EXCITATION_MOMENT):
            what = quantity.name.split("_")[1]
            about = (
                f"{what} of the waves of a sea from elsewhere on {', '.join(parts)}, in the inertial frame"
            )
            first[what] = builder.add_inputs(dotted(*parts, quantity.name), quantity, about, nodes)

        builder.tables["n_wrench_input"].add(
            wrench_marker=marker,
            wrench_reaction=-1,
            wrench_axes=-1,
            wrench_force=first["force"],
            wrench_moment=first["moment"],
        )


def _check_headings(path, known, wanted):
    """Raises SceneError for directions (rad) that a file does not reach."""
    turned = known[0] + np.mod(wanted - known[0] + BESIDE, 2 * np.pi) - BESIDE

    if turned.max() > known[-1] + BESIDE:
        text = (
            f"has no waves that travel at {np.degrees(turned.max()):.4g} degrees; headings are from {np.degrees(known[0]):.4g} to "
            f"{np.degrees(known[-1]):.4g}"
        )
        raise SceneError([Problem(path, text)])


def meet_waves(builder, model):
    """Moves the places where waves meet bodies and members, and the water that members move along, to where these start once
    loops are closed, if that is known.
    """
    if not ((builder.wave_places or builder.wet_members) and model.n_constraint):
        return

    m, d = model.views()

    if entry.prepare(m, d) != OK or entry.initialise(m, d, 0.0) != OK:
        return

    entry.compute_outputs(m, d, np.zeros(model.n_y))

    for array, row, size, marks, part in builder.wave_places:
        first, last = (np.array(markers.position(m, d, mark)) for mark in (marks[0], marks[-1]))
        place = (first + part * (last - first))[:size]
        begin = model.ints[layout.SLOT[array]] + row * size
        model.reals[begin : begin + size] = place

    for row, marks, added in builder.wet_members:
        begin = model.ints[layout.SLOT["six_by_six_added"]] + 36 * row
        ends = (np.array(markers.position(m, d, mark)) for mark in marks)
        model.reals[begin : begin + 36] = added(*ends).ravel()


def _tell_outside(builder, path, waves, known, what):
    """A notice of a sea that goes beyond a file's frequencies; what : (what has these, what is taken outside)."""
    energy = waves.amplitude**2
    outside = energy[(waves.omega < known[0]) | (waves.omega > known[-1])].sum() / energy.sum()

    if outside > OUTSIDE:
        text = (
            f"{what[0]} reaches from {known[0]:.4g} to {known[-1]:.4g} rad/s; {100 * outside:.3g} % of the sea's energy is outside, "
            f"where {what[1]}"
        )
        builder.notice(path, text)


def _add_outputs(builder, name, force, rows):
    inputs = force.hydrodynamics.excitation == "input"
    missing = (
        "there is radiation = false",
        "there are no waves that act",
        "there is neither damping nor quadratic",
    )

    for k, (end, parts) in enumerate(zip(force.between, _parts(name, force))):
        words = ", ".join(parts)

        for output in force.output:
            quantity = HYDRODYNAMICS_OUTPUTS[output]
            kind, which = HYDRODYNAMICS_KINDS[output]

            if rows[which][k] < 0:
                what = 'it is an input: excitation = "input"' if which == 1 and inputs else missing[which]
                raise SceneError([Problem(("force", name, "output"), f'no "{output}": {what}')])

            builder.add_outputs(
                dotted(*parts, output),
                Source(kind, rows[which][k]),
                quantity.unit,
                f"{words}: {quantity.text}",
                [builder.node_of(end)],
            )
