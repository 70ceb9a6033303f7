"""The static equilibrium of a scene: where it is, what is borne there, whether it stays, and the scene with
it as its start."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
import scipy  # which imports its parts when they are asked for

from ..compiler.joint_kinds import kind_of
from ..compiler.variables import dotted, subscripts
from ..kernels.motion.coordinates import TWIST, turn
from ..scene import SceneData
from ..scene.errors import listed
from ..scene.rare import END_FRAMES
from ..scene.starts import RATES
from ..vocabulary import EFFORT_OUTPUTS, POSE_EFFORTS, REACTIONS
from .equilibrium import NoEquilibrium, Rest, approach, settle, tiny
from .manifold import Manifold
from .places import mechanism_of, stilled

# drawn starts of a search for all equilibria: how many, how far (rad, or lengths of the scene) they are
DRAWN = 40
FAR = 3.0

# positions (rad, or parts of the scene's length) that are one equilibrium
SAME = 1e-5

# m, rad, deg that are rounding of 0; sine of the pitch from 1 on, near which yaw and roll are one
NOISE = 1e-15
GIMBAL = 1e-6

# what a motion of one joint may have of others'
ALONE = 1e-6

# share of the largest coordinate from which on another one is told of a motion
TOLD = 0.3


@dataclass(frozen=True)
class Equilibrium:
    """A static equilibrium.

    scene : with the equilibrium as its start; what had a speed has none.
    coordinates : of the joints by variable name, SI. outputs : of the scene, by name. positions : {body: (r
        (3,) m, E (4,))} in the inertial frame.
    reactions : {joint: (force (3,) N, moment (3,) N m)} on its second marker, in the first one's axes.
    efforts : {variable: N or N m} of springs, stops and drivers along joints, on the second markers.
    stable : True, False, or None where some motion has no stiffness. motions : those that it loses, or that
        have none, in words.
    squares : (n,) squares of the undamped frequencies, 1/s2, ascending.
    error : how far off it may be (rad, or parts of the scene's length). iterations : of the search.
    notices : what a user should be told.
    """

    scene: SceneData
    coordinates: dict[str, float]
    outputs: dict[str, float]
    positions: dict[str, tuple[np.ndarray, np.ndarray]]
    reactions: dict[str, tuple[np.ndarray, ...]]
    efforts: dict[str, float]
    units: dict[str, str | None]
    stable: bool | None
    motions: list[str]
    squares: np.ndarray
    error: float
    iterations: int
    notices: list[str]
    manifold: Manifold = field(repr=False)

    @property
    def frequencies(self):
        """(n,) Hz, undamped, of the motions that come back."""
        return np.sqrt(self.squares[self.squares > 0.0]) / (2 * np.pi)

    def modes(self):
        """The modes about it; see `mbdfmi.analysis.modes.Modes`."""
        from .linear import about

        return about(self.manifold, [], []).modes()


def equilibrium(
    scene: SceneData,
    *,
    hold: Mapping[str, float] | None = None,
    parameters: Mapping[str, float] | None = None,
    time: float = 0.0,
    nearest: bool = False,
    weather: bool = False,
    progress: Callable[[str], None] | None = None,
) -> Equilibrium:
    """The static equilibrium that a scene comes to from its start, with all speeds 0 and its drives held
    where they are at a time.

    hold : values of inputs by name, else at their start values. parameters : values other than the scene's,
        by name.
    time : s, of drives and of loads over time. weather : with the waves of that time and the steady wind,
        which are left out otherwise, unless an input that is held tells the wind. nearest : the first that is
        found, also where it is not stable.

    Dampers and friction, which take nothing at rest, do not matter. Raises NoEquilibrium, which says what
    moves away; SimulationError where loops do not close; KeyError, ValueError.
    """
    seen = observed(scene)
    mechanism = mechanism_of(seen, hold, parameters, time)

    try:
        manifold, rest = settle(mechanism, nearest, progress, weather)
    except NoEquilibrium as error:
        raise NoEquilibrium("; ".join([str(error), *stilled(mechanism)])) from None

    return _told(scene, manifold, rest, weather)


def equilibria(
    scene: SceneData,
    *,
    n: int = DRAWN,
    seed: int = 1,
    hold: Mapping[str, float] | None = None,
    parameters: Mapping[str, float] | None = None,
    time: float = 0.0,
    weather: bool = False,
    progress: Callable[[str], None] | None = None,
) -> list[Equilibrium]:
    """The equilibria that are found from n drawn starts beside the scene's own, stable and not, as
    `equilibrium` takes the rest. Of those that differ by a motion without stiffness alone, one is given.
    There may be others.
    """
    seen = observed(scene)
    mechanism = mechanism_of(seen, hold, parameters, time)
    draw = np.random.default_rng(seed)
    found: list[tuple[Manifold, Rest]] = []

    for k in range(n + 1):
        if progress:
            progress(f"start {k + 1} of {n + 1}, {len(found)} found")

        one = mechanism.again(parameters, mechanism.held, time)

        try:
            result = (
                settle(one, True, None, weather) if k == 0 else approach(one, draw, FAR, k % 2 == 1, weather)
            )
        except NoEquilibrium:
            continue

        if not any(_are_one(result, other) for other in found):
            found.append(result)

    if not found:
        raise NoEquilibrium(f"no equilibrium was found from {n + 1} starts")

    order = {True: 0, None: 1, False: 2}
    found.sort(key=lambda pair: order[pair[1].stable])
    return [_told(scene, manifold, rest, weather) for manifold, rest in found]


def _are_one(one, other):
    """Whether two equilibria are the same, motions without stiffness apart."""
    (manifold, rest), (second, _) = one, other
    r, s = (m.d.r.reshape(-1, 3) for m in (manifold, second))
    A, B = (m.d.A.reshape(-1, 3, 3) for m in (manifold, second))
    length = manifold.m.scene_length[0]
    apart = max(np.abs(r - s).max() / length, np.abs(A - B).max())

    if apart <= SAME or rest.stable is not None:
        return apart <= SAME

    # where something may stand anywhere, frequencies tell
    squares, others = rest.squares, other[1].squares
    return np.abs(squares - others).max() <= 1e-6 * max(np.abs(squares).max(), 1e-30)


# what is to be seen


def allowed(joint, name) -> bool:
    """Whether a joint may have an output."""
    validate = type(joint).model_fields["output"].metadata[0].func

    try:
        validate([name])
    except ValueError:
        return False

    return True


def _coordinates(joint):
    """Names of outputs that tell where a joint is."""
    names = [coordinate.position.name for coordinate in joint.coordinates]
    names += ["s"] if isinstance(joint, END_FRAMES) else []
    names += ["position", "zyx"] if joint.kind == "prescribed" else []
    return [name for name in dict.fromkeys(names) if allowed(joint, name)]


def _efforts(joint):
    """Names of outputs that tell what acts along a joint's coordinates."""
    names = [name for name, part in EFFORT_OUTPUTS.items() if name != "effort" and getattr(joint, part, None)]
    names += list(POSE_EFFORTS) if joint.kind == "prescribed" else []
    return [name for name in names if name != "damper_effort" and allowed(joint, name)]


def _reactions(joint):
    # a fixed joint whose reaction nobody asks for makes one body of its two
    if joint.kind == "fixed" and not joint.output:
        return []

    return [name for name in list(REACTIONS)[:2] if allowed(joint, name)]


def observed(scene) -> SceneData:
    """The scene with outputs of all that is to be told of an equilibrium."""
    joints = {}

    for name, joint in scene.joint.items():
        rates = [coordinate.rate.name for coordinate in joint.coordinates]
        rates = [rate for rate in rates if allowed(joint, rate)]
        wanted = [*_coordinates(joint), *rates, *_efforts(joint), *_reactions(joint)]
        joints[name] = joint.model_copy(update={"output": list(dict.fromkeys([*joint.output, *wanted]))})

    return scene.model_copy(update={"joint": joints})


def _told(scene, manifold, rest, weather) -> Equilibrium:
    """What there is to tell of an equilibrium that was found."""
    mechanism = manifold.mechanism
    manifold.put()
    model, instance = manifold.model, mechanism.instance
    values = dict(zip((v.name for v in model.of_causality("output")), instance.outputs().tolist()))
    units = {v.name: v.unit for v in model.variables}
    kept = {v.name for v in _named_outputs(scene, model)}
    coordinates, efforts, reactions = {}, {}, {}

    for name, joint in scene.joint.items():
        for what, into in ((_coordinates, coordinates), (_efforts, efforts)):
            for output in what(joint):
                into |= {key: values[key] for key in _elements(values, dotted(name, output))}

        pair = [_elements(values, dotted(name, output)) for output in _reactions(joint)]

        if pair:
            reactions[name] = tuple(np.array([values[key] for key in keys]) for keys in pair)

    poses = []

    for body in scene.body:
        node, (r, A) = model.tree.marker(mechanism.scene, body)
        turned = manifold.d.A.reshape(-1, 3, 3)[node]
        poses.append((manifold.d.r.reshape(-1, 3)[node] + turned @ r, turned @ A))

    quats = scipy.spatial.transform.Rotation.from_matrix([A for _, A in poses]).as_quat() if poses else []
    positions = {body: (r, E) for body, (r, _), E in zip(scene.body, poses, quats)}
    motions = _motions(manifold, rest)
    notices = list(instance.notices)

    if rest.left:
        came = "an unstable equilibrium" if rest.left == 1 else f"{rest.left} unstable equilibria"
        notices.append(f"the search came through {came} (nearest, --nearest, stays at the first)")

    notices += stilled(mechanism)

    if mechanism.has_weather and not weather:
        notices.append(
            "in still air and water: wind and waves are left out (weather, --weather, lets them act)"
        )

    notices += _wound(scene, manifold)

    if any(joint.friction for joint in scene.joint.values() if hasattr(joint, "friction")):
        notices.append("dry friction holds nothing here: with it, a range of places would be at rest")

    return Equilibrium(
        scene=started(scene, values, manifold, rest),
        coordinates=coordinates,
        outputs={name: value for name, value in values.items() if name in kept},
        positions=positions,
        reactions=reactions,
        efforts=efforts,
        units=units,
        stable=rest.stable,
        motions=motions,
        squares=rest.squares,
        error=rest.error,
        iterations=rest.iterations,
        notices=notices,
        manifold=manifold,
    )


def _wound(scene, manifold):
    """What is told of torsion springs that rest more than half a turn away: runs begin within that."""
    m = manifold.m
    twists = [t for t in range(m.n_turn) if m.coordinate_kind[m.turn_coordinate[t]] == TWIST]
    names = [name for name, force in scene.force.items() if force.kind == "torsion"]
    angles = [manifold.d.z[turn(m, t)] for t in twists]
    return [
        f'the torsion spring "{name}" rests at {np.degrees(angle):.6g} deg: a run that starts there counts '
        "from within half a turn, and does not stay unless what the spring rests at is less by whole turns"
        for name, angle in zip(names, angles, strict=True)
        if abs(angle) > np.pi * (1.0 + 1e-12)
    ]


def _named_outputs(scene, model):
    """Outputs that the scene itself asks for."""
    added = set()

    for name, joint in scene.joint.items():
        rates = {coordinate.rate.name for coordinate in joint.coordinates}
        new = {*_coordinates(joint), *rates, *_efforts(joint), *_reactions(joint)} - set(joint.output)
        added |= {dotted(name, output) for output in new}

    return [v for v in model.of_causality("output") if v.name.split("[")[0] not in added]


def _elements(values, name):
    """Names of the elements of an output, in their order."""
    return [name] if name in values else [key for key in values if key.startswith(f"{name}[")]


def _motions(manifold, rest):
    """Motions that an equilibrium loses, or that have no stiffness, in words."""
    if not len(rest.squares):
        return []

    none = tiny(rest.squares)
    told = []

    for square, shape in zip(rest.squares, rest.shapes.T):
        if square > none:
            break

        way = manifold.V @ shape / manifold.unit
        order = [k for k in np.argsort(-np.abs(way)) if abs(way[k]) >= TOLD * np.abs(way).max()][:4]
        names = listed([manifold.named[k].position for k in order])
        how = "no stiffness" if square >= -none else f"away with {np.sqrt(-square):.4g} 1/s"
        told.append(f"{names}: {how}")

    return told


# the scene that starts there


def started(scene, values, manifold, rest) -> SceneData:
    """The scene with an equilibrium as its start; values : of all outputs by name. Speeds are 0, but for
    those of joints of one freedom that turn or slide without stiffness: a rotor spins on.
    """
    idle = _idle(manifold, rest)
    joints = {}

    for name, joint, start, given in _starts(scene, values, manifold):
        given |= {key: getattr(start, key) for key in _speeds(joint) if name in idle}
        joints[name] = joint.model_copy(update={"start": type(start).model_validate(given)})

    forces = scene.force | _lengths(scene, manifold)
    return scene.model_copy(update={"joint": scene.joint | joints, "force": forces})


def _lengths(scene, manifold):
    """Spring-dampers whose length at the start is that without force, with this told, as the start is
    another.
    """
    forces = {}
    struts = iter(manifold.d.strut_start.tolist())

    for name, force in scene.force.items():
        if force.kind != "spring_damper":
            continue

        length = next(struts)

        if force.spring_damper.rest_length is None and force.spring_damper.table is None:
            spec = force.spring_damper.model_copy(update={"rest_length": length})
            spec.model_fields_set.add("rest_length")
            forces[name] = force.model_copy(update={"spring_damper": spec})

    return forces


def started_moving(scene, values, manifold) -> SceneData:
    """The scene with a state as its start, positions and velocities; values : of all outputs of `observed` by
    name.
    """
    joints = {}

    for name, joint, start, given in _starts(scene, values, manifold):
        for coordinate in joint.coordinates:
            rate = coordinate.rate
            numbers = [values[dotted(name, rate.name) + ending] for ending in subscripts(rate.shape)]

            if any(numbers) and rate.name in type(start).model_fields:
                given[rate.name] = _plain(numbers)

        joints[name] = joint.model_copy(update={"start": type(start).model_validate(given)})

    return scene.model_copy(
        update={"joint": scene.joint | joints, "force": scene.force | _lengths(scene, manifold)}
    )


def _speeds(joint):
    """Keys of a joint's start that say how fast it starts."""
    return [key for key in joint.start_given if key.startswith(RATES)]


def _idle(manifold, rest):
    """Joints of one freedom that move alone without stiffness."""
    found = set()

    if not len(rest.squares):
        return found

    free = np.abs(rest.squares) <= tiny(rest.squares)
    ways = manifold.V @ rest.shapes[:, free] / manifold.unit[:, None]

    for k, named in enumerate(manifold.named):
        alone = np.eye(len(manifold.free))[k]
        left = alone - ways @ np.linalg.lstsq(ways, alone, rcond=None)[0] if ways.size else alone

        if np.abs(left).max() < ALONE and [other.joint for other in manifold.named].count(named.joint) == 1:
            found.add(named.joint)

    return found


def _starts(scene, values, manifold):
    """(name, joint, its start as the scene has it, its positions as a table) of the joints that the state is
    told by: those of the tree, and others with a start of their own.
    """
    tree = {node.joint for node in manifold.model.tree.nodes}

    for name, joint in scene.joint.items():
        start = getattr(joint, "start", None)

        if start is None or joint.driver or (name not in tree and not joint.start_given):
            continue

        given = _start(name, joint, values, start)

        if given is not None:
            yield name, joint, start, given


def _start(name, joint, values, start):
    """A joint's start as a table; None where it has no coordinates of its own."""
    found = {}
    coordinates = joint.coordinates

    if isinstance(joint, END_FRAMES):
        s = [values[key] for key in _elements(values, dotted(name, "s"))]
        field_ = np.size(getattr(start, "s", None) or 0.0)

        if "s" not in type(start).model_fields:
            return None

        return {"s": s[0] if len(s) == 1 else s[: max(2, field_)]}

    led = kind_of(joint).led(joint)

    for k, coordinate in enumerate(coordinates):
        quantity = coordinate.position
        key = dotted(name, quantity.name)
        numbers = [values[key + ending] for ending in subscripts(quantity.shape)]

        if k in led and quantity.width == 1:
            continue

        if quantity.name == "euler_parameters":
            found |= _orientation(numbers, start)
        elif f"{quantity.name}_deg" in start.model_fields_set:
            found[f"{quantity.name}_deg"] = _plain(np.degrees(numbers))
        else:
            found[quantity.name] = _plain(numbers)

    return found or None


def _plain(numbers):
    """A number, or a list of several."""
    numbers = [float(number) if abs(number) > NOISE else 0.0 for number in numbers]
    return numbers[0] if len(numbers) == 1 else numbers


def _orientation(E, start):
    """An orientation as it was written before, else as yaw, pitch, roll in degrees; where these do not tell,
    as Euler parameters.
    """
    E = np.array(E) / np.linalg.norm(E)
    # sin(pitch)
    upright = abs(2.0 * (E[1] * E[3] - E[0] * E[2])) < 1.0 - GIMBAL

    if "euler_parameters" in start.model_fields_set or not upright:
        return {"euler_parameters": _plain(E)}

    zyx = scipy.spatial.transform.Rotation.from_quat(E).as_euler("ZYX")
    return (
        {"zyx_rad": _plain(zyx)}
        if "zyx_rad" in start.model_fields_set
        else {"zyx_deg": _plain(np.degrees(zyx))}
    )
