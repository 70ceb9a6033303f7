"""Checks across the tables of a scene: names, references, connections, clashes of variables.

References are checked on the data as written, any part of which may be wrong in other ways, so
that one reading finds all that is wrong. What has not the right form is passed over here: it has
its message from the schema.
"""

from itertools import permutations

from pydantic import BaseModel

from .errors import (
    NAMED_TABLES,
    Problem,
    did_you_mean,
    key_text,
    listed,
    place_text,
    quoted,
    show,
)
from .names import FRAMES, fmi_name
from .rare import CONSTRAINTS, END_FRAMES

ORDINALS = ("first", "second", "third")


def cross_references(data):
    """The problems of names and references in the data (a dict) of a scene."""
    if not isinstance(data, dict):
        return []

    bodies = {name: body for name, body in _entries(data, "body").items() if _is_table(body)}
    ground = _get(data, "ground")
    problems = _ambiguous_names(data, bodies, ground)

    if not bodies:
        if _get(data, "body") in (None, {}):
            problems.append(Problem((), "there is no body; write a table [body.NAME]"))
        return problems

    joints = {_plain(name): joint for name, joint in _entries(data, "joint").items()}
    for name, coupling in _entries(data, "coupling").items():
        if text := _wrong_coupling(coupling, joints):
            problems.append(Problem(("coupling", name, "between"), text))
    problems += [Problem(("solver", "trim", "steady"), text) for text in _not_there(data, joints)]

    markers = {_plain(name): _plain_entries(body, "marker") for name, body in bodies.items()}
    markers["ground"] = _plain_entries(ground, "marker")
    markers["inertial"] = {}
    wrong = _misplaced(data, markers, joints)
    problems += wrong + _unseen(data, bodies, ground, markers, joints)
    shapes = {
        (_plain(owner), _plain(name)): marker
        for owner, holder in (*bodies.items(), ("ground", ground))
        for name, marker in _entries(holder, "marker").items()
    }
    in_doubt = {problem.path[:2] for problem in wrong}
    joined = [
        (name, joint, ends)
        for name, joint in _entries(data, "joint").items()
        if (ends := _ends(joint)) and ("joint", name) not in in_doubt
    ]
    for name, joint, ends in joined:
        texts = _missing_shapes(joint, ends, shapes)
        problems += [Problem(("joint", name, _key_of(joint)), text) for text in texts]

    # while a joint's ends are in doubt, so is what hangs on it
    if len(joined) == len(_entries(data, "joint")):
        problems += _loose_bodies(bodies, joined)
    return problems


def _ambiguous_names(data, bodies, ground):
    """Problems of names that are one in an FMU."""
    problems = []
    for table in NAMED_TABLES:
        problems += _same_names((table,), _entries(data, table))
    problems += _shared_names(data)
    for name, body in bodies.items():
        problems += _same_names(("body", name, "marker"), _entries(body, "marker"))
    return problems + _same_names(("ground", "marker"), _entries(ground, "marker"))


def unfit_shapes(scene):
    """The problems of a valid scene's curves that are to touch but are not planar."""
    problems = []
    for name, joint in scene.joint.items():
        if joint.kind != "curve_on_curve":
            continue
        for end in joint.between:
            if not scene.marker(end).curve.is_planar:
                text = f"the curve on {quoted(end)} must lie in a plane z = constant"
                problems.append(Problem(("joint", name, "between"), text))
    return problems


def unfit_water(scene):
    """The problems of a valid scene in which water has no weight, or one that does not point at its bottom."""
    x, y, z = scene.gravity

    if x == y == 0.0 > z:
        return []

    found = "central_gravity" if scene.central_gravity else f"gravity {show(scene.gravity)}"
    text = f"water lies in the plane z = 0, and gravity must point along -z; found {found}"
    waves = [Problem(("sea", "waves"), text)] if scene.sea and scene.sea.waves else []
    return waves + [
        Problem(("force", name, force.kind), text)
        for name, force in scene.force.items()
        if force.kind in ("hydrostatics", "hydrodynamics", "catenary")
    ]


def elevations_without_waves(scene):
    """The problems of markers in a valid scene that ask for the elevation of a sea without waves."""
    if scene.sea and scene.sea.waves:
        return []

    text = 'output "elevation" is that of waves, and there are none, as in [sea] waves = { jonswap = { hs = 2, tp = 8 } }'
    asked = [(("body", name), body) for name, body in scene.body.items()]
    asked += [
        (("body", name, "marker", marker), spec)
        for name, body in scene.body.items()
        for marker, spec in body.marker.items()
    ]
    return [Problem((*path, "output"), text) for path, spec in asked if "elevation" in spec.output]


def rotors_without_wind(scene):
    """The problems of rotors in a valid scene without wind, and of wind that nothing is in."""
    rotors = [name for name, force in scene.force.items() if force.kind == "rotor"]

    if rotors and not scene.wind:
        text = "a rotor needs a wind, as in [wind] steady = { velocity = [12, 0, 0] }"
        return [Problem(("force", name, "rotor"), text) for name in rotors]
    if scene.wind and not rotors:
        return [
            Problem(("wind",), "nothing is in the wind; a rotor is, as a force: rotor = { radius, table }")
        ]
    return []


def clashes(scene):
    """The problems of inputs and outputs of a valid scene that get the same name in an FMU."""
    problems, seen = [], {}
    for path, variable in _variables(scene):
        first = seen.setdefault(variable, path)
        if first[:-1] == path[:-1] and first != path:
            text = f"the variable {variable} cannot be both input and output; drop one of them"
            problems.append(Problem(path, text))
        elif first != path:
            place = place_text(first[:-1]).rstrip(":")
            problems.append(Problem(path, f"the variable {variable} exists already, from {place}"))
    return problems


def _variables(scene):
    """(path, FMU name without indices) of all inputs and outputs."""
    for key in ("sea", "wind"):
        if part := getattr(scene, key):
            yield from _variables_of((key,), key, part)

    for table in NAMED_TABLES:
        for name, entry in getattr(scene, table).items():
            yield from _variables_of((table, name), fmi_name(name), entry)
            for marker, frame in getattr(entry, "marker", {}).items():
                path = (table, name, "marker", marker)
                yield from _variables_of(path, f"{fmi_name(name)}.{fmi_name(marker)}", frame)


def _variables_of(path, prefix, entry):
    for item in getattr(entry, "input", None) or []:
        yield (*path, "input"), f"{prefix}.{item}"
    for item in entry.output:
        yield (*path, "output"), f"{prefix}.{item}"


# data as written


def _get(holder, key):
    return holder.get(key) if isinstance(holder, dict) else getattr(holder, key, None)


def _is_table(value):
    return isinstance(value, (dict, BaseModel))


def _entries(holder, key):
    entries = _get(holder, key)
    if not isinstance(entries, dict):
        return {}
    return {name: entry for name, entry in entries.items() if isinstance(name, str)}


def _plain(name):
    return name.strip()


def _plain_entries(holder, key):
    return dict.fromkeys(_plain(name) for name in _entries(holder, key))


def _ends(entry):
    """The ends of an entry as lists of names; [] when they have not that form."""
    between, on = _get(entry, "between"), _get(entry, "on")
    if isinstance(on, str):
        between = [on]
    elif isinstance(on, (list, tuple)) and _get(entry, "hydrodynamics") is not None:
        between = on
    elif not isinstance(between, (list, tuple)) or len(between) != 2:
        return []
    if not all(isinstance(end, str) for end in between):
        return []

    ends = [[_plain(name) for name in end.split(".")] for end in between]
    return ends if all(len(end) <= 2 and all(end) for end in ends) else []


# what is wrong with it


def _same_names(path, names):
    problems, seen = [], {}
    for name in names:
        first = seen.setdefault(fmi_name(_plain(name)), name)
        if first != name:
            text = f"the name is the same as {quoted(first)} in an FMU; choose another"
            problems.append(Problem((*path, name), text))
    return problems


def _shared_names(data):
    # they have parameters such as stiffness and ratio; those of bodies have other names
    problems, taken = [], {}
    for table in ("joint", "coupling", "force"):
        for name in _entries(data, table):
            first = taken.setdefault(fmi_name(_plain(name)), table)
            if first != table:
                text = f"a {first} has this name too; choose another"
                problems.append(Problem((table, name), text))
    return problems


def _not_there(data, joints):
    """What is wrong with the joints that a trim wants steady: texts."""
    names = _get(_get(_get(data, "solver"), "trim"), "steady")
    for name in names if isinstance(names, (list, tuple)) else ():
        if isinstance(name, str) and _plain(name) not in joints:
            yield f"no joint {quoted(name)}; there is {listed(joints) or 'none'}." + did_you_mean(
                name, joints
            )


def _wrong_coupling(coupling, joints):
    """What is wrong with the joints of a coupling, or None. joints : {name: joint}."""
    names = _get(coupling, "between")
    if not isinstance(names, (list, tuple)) or len(names) < 2:
        return None
    if not all(isinstance(name, str) for name in names):
        return None

    names = [_plain(name) for name in names]
    for name in names:
        if name not in joints:
            text = f"no joint {quoted(name)}; there is {listed(joints) or 'none'}."
            return text + did_you_mean(name, joints)
    for k, name in enumerate(names):
        if name in names[:k]:
            if len(names) == 2:
                return f"both are {quoted(name)}; a coupling is between two joints"
            return f"two of them are {quoted(name)}; a coupling is between different joints"

    from .couplings import COUPLINGS, CouplingBase

    cls = next((cls for cls in COUPLINGS if _get(coupling, cls.kind) is not None), CouplingBase)
    for k, name in enumerate(names):
        kinds = cls.kinds[min(k, 1)]
        which = ORDINALS[k] if k < len(ORDINALS) else f"{k + 1}th"
        if not any(_get(joints[name], kind) is not None for kind in kinds):
            what = cls.kind if cls.kind else "a coupling"
            return f"{quoted(name)} is not {listed(kinds, 'or')}, as the {which} joint of {what} must be"
    if all(_get(joints[name], "driver") is not None for name in names):
        which = (
            "both joints are driven; one of them follows the other"
            if len(names) == 2
            else "all joints are driven"
        )
        return f"{which}, so drop a driver"
    return None


def _misplaced(data, markers, joints):
    """Problems of joints, forces and measures whose ends are not where they could be."""
    return [
        Problem((table, name, _key_of(entry)), text)
        for table in ("joint", "force", "measure")
        for name, entry in _entries(data, table).items()
        for ends in [_ends(entry)]
        for text in (
            _wrong_places(ends, markers, joints)
            if _key_of(entry) == "on"
            else _wrong_ends(table, ends, markers, joints, _get(entry, "member") is not None)
        )
    ]


def _key_of(entry):
    """The key that its ends are written with."""
    return "between" if _get(entry, "on") is None else "on"


def _wrong_places(ends, markers, joints):
    """Texts about the one end of a load, or the ends of forces of the sea on several bodies."""
    wrong = [text for end in ends if (text := _wrong_end(end, markers, joints))]
    if wrong:
        return wrong

    bodies = [end[0] for end in ends]
    frames = [body for body in bodies if body in FRAMES]
    if frames:
        return [f"{quoted(frames[0])} does not move by a load; name a body"]

    twice = [body for k, body in enumerate(bodies) if body in bodies[:k]]
    return [f"two of them are on {quoted(twice[0])}; each is a body of its own"] if twice else []


def _wrong_ends(table, ends, markers, joints, within=False):
    """Texts about the ends of an entry of the table; markers is {body: its markers}. within : both are to be on one body."""
    wrong = [text for end in ends if (text := _wrong_end(end, markers, joints))]
    if not ends or wrong:
        return wrong

    first, second = (end[0] for end in ends)
    if within:
        return (
            []
            if first == second
            else [f"a member is of one body, found {quoted(first)} and {quoted(second)}"]
        )
    if first == second:
        return [f"both ends are on {quoted(first)}; a {table} acts between two bodies"]
    if first in FRAMES and second in FRAMES and table != "measure":
        return [f"neither end is on a body; a {table} acts on one at least"]
    return []


def _wrong_end(end, markers, joints):
    """What is wrong with one end (a list of names), or None."""
    body, written = end[0], ".".join(end)
    if body in markers and (len(end) == 1 or end[1] in markers[body]):
        return None

    known = [*markers, *(f"{b}.{marker}" for b in markers for marker in markers[b])]
    if body in markers:
        frames = {"ground": "the ground", "inertial": "the inertial frame"}
        owner = frames.get(body, f"body {quoted(body)}")
        text = f"no marker {quoted(end[1])} on {owner}; it has {listed(markers[body]) or 'none'}."
        return text + did_you_mean(written, [name for name in known if name.startswith(body + ".")])

    text = f"no body {quoted(body)}; there is {listed(markers)}."
    if body in joints:
        text += f" {quoted(body)} is a joint."

    # a marker without its body is a likely slip
    same = [name for name in known if name.partition(".")[2] == body]
    return text + did_you_mean(same[0] if same else written, known)


def _unseen(data, bodies, ground, markers, joints):
    """Problems of looks: ends that lines, paths and the picture's frame name and that are not there."""
    view, problems = _get(data, "view"), []
    frame, paths = _get(view, "frame"), _get(view, "paths")
    if isinstance(frame, str) and _plain(frame) not in markers:
        text = f"no body {quoted(frame)}; there is {listed(markers)}."
        problems.append(Problem(("view", "frame"), text + did_you_mean(frame, markers)))

    paths = [paths] if isinstance(paths, str) else paths if isinstance(paths, (list, tuple)) else []
    for k, end in enumerate(paths):
        if isinstance(end, str) and (text := _wrong_end(_split(end), markers, joints)):
            problems.append(Problem(("view", "paths", k), text))

    for path, owner, shape in _lines(bodies, ground):
        for k, end in enumerate(shape):
            names = _split(end) if isinstance(end, str) else [owner]
            if names[0] != owner:
                text = f"{quoted(end)} is not on {quoted(owner)}; a line joins ends of what it is drawn on"
            else:
                text = _wrong_end(names, markers, joints)
            if text:
                problems.append(Problem((*path, "line", k), text))
    return problems


def _lines(bodies, ground):
    """(path, owner, ends) of all shapes that are lines."""
    holders = [(("body", name), _plain(name), body) for name, body in bodies.items()]
    for path, owner, holder in [*holders, (("ground",), "ground", ground)]:
        frames = [((*path, "marker", name), marker) for name, marker in _entries(holder, "marker").items()]
        for place, drawn in [(path, holder), *frames]:
            shapes = _get(drawn, "shape")
            shapes = shapes if isinstance(shapes, (list, tuple)) else [shapes]
            for k, shape in enumerate(shapes):
                ends = _get(shape, "line")
                if isinstance(ends, (list, tuple)):
                    yield (*place, "shape", k), owner, ends


def _split(end):
    return [_plain(name) for name in end.split(".", 1)]


def _missing_shapes(joint, ends, markers):
    """Texts about curves and surfaces that an end frame needs; markers is {(body, name): marker}."""
    end_frame = next((rare.type for rare in END_FRAMES if _get(joint, rare.kind) is not None), None)
    if not end_frame:
        return

    examples = {"curve": "{ circle = { radius = 1 } }", "surface": "{ sphere = { radius = 1 } }"}
    for end, shape, which in zip(ends, end_frame.shapes, ("first", "second")):
        if shape and _get(markers.get(tuple(end)), shape) is None:
            marker = key_text(end[1]) if len(end) == 2 else "NAME"
            yield (
                f"{end_frame.kind} needs a {shape} on its {which} end, {quoted('.'.join(end))}; "
                f"write marker.{marker} = {{ {shape} = {examples[shape]} }} and name that marker"
            )

    if end_frame.shapes[0] == "surface":
        yield from _unfit_surfaces(end_frame, ends, markers)


def _unfit_surfaces(end_frame, ends, markers):
    """Texts about surfaces that cannot bear anything, or cannot touch another one."""
    from .surfaces import CONVEX, HOLLOW

    first, second = (_get(markers.get(tuple(end)), "surface") for end in ends)

    if _get(first, "disk") is not None:
        yield (
            f"{end_frame.kind}: the first surface, of {quoted('.'.join(ends[0]))}, is a disk, of which only the edge is there to touch "
            "another surface; make it the second one"
        )

    for kind in HOLLOW:
        if end_frame.shapes[1] == "surface" and _get(second, kind) is not None:
            yield (
                f"{end_frame.kind}: the second surface, of {quoted('.'.join(ends[1]))}, must be one of {listed(CONVEX)}, which are "
                f"round outwards and touch in a point; found a {kind}. Exchange the two ends if the first one is such"
            )


def _constraint_kind(joint):
    """The kind of a joint that only constrains, or None."""
    kinds = (rare.kind for rare in CONSTRAINTS + END_FRAMES)
    return next((kind for kind in kinds if _get(joint, kind) is not None), None)


def _loose_bodies(bodies, joined):
    """Problems of bodies from which no chain of joints (name, joint, ends) leads to ground."""
    neighbours = {}
    for _, joint, ends in joined:
        if not _constraint_kind(joint):
            for one, other in permutations([end[0] for end in ends], 2):
                neighbours.setdefault(one, []).append(other)

    # body: a joint that only constrains it
    slack = {
        end[0]: (name, kind)
        for name, joint, ends in joined
        if (kind := _constraint_kind(joint))
        for end in ends
    }
    reached, waiting = set(FRAMES), list(FRAMES)
    while waiting:
        new = set(neighbours.get(waiting.pop(), ())) - reached
        reached |= new
        waiting += new

    problems = []
    for name in bodies:
        plain = _plain(name)
        if plain not in reached:
            text = "no chain of joints connects it to ground"
            if plain in slack:
                joint, kind = slack[plain]
                text += f" ({quoted(joint)} is {kind}, which only takes freedoms away)"
            text += (
                "; to let it move freely, write a joint with free = {} and "
                f'between = ["ground", {quoted(plain)}]'
            )
            problems.append(Problem(("body", name), text))
    return problems
