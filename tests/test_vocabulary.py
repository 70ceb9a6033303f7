"""Words are said once: schema, vocabulary, compiler and kernels know the same names, widths and units."""

import pytest

from mbdfmi import vocabulary
from mbdfmi.compiler import bodies, forces, joints
from mbdfmi.compiler.joint_kinds import JOINT_KINDS, kind_of, scalars
from mbdfmi.kernels import outputs
from mbdfmi.kernels.joints import KINDS, N_Q, N_V
from mbdfmi.scene import joints as joint_classes
from mbdfmi.scene.constraints import CONSTRAINTS
from mbdfmi.scene.end_frames import END_FRAMES
from mbdfmi.scene.joint_base import JointBase
from mbdfmi.scene.prescribed import Prescribed
from mbdfmi.units import UNITS

# tables of the vocabulary, and the compiler's kinds of the same words
TABLES = {
    "marker": (vocabulary.MARKER_OUTPUTS, bodies.MARKER_KINDS),
    "measure": (vocabulary.MEASURES, bodies.MEASURE_KINDS),
    "ground": (vocabulary.GROUND_OUTPUTS, bodies.GROUND_KINDS),
    "scene": (vocabulary.SCENE_OUTPUTS, bodies.SCENE_KINDS | {"multipliers": outputs.MULTIPLIER}),
    "solver": (vocabulary.SOLVER_OUTPUTS, bodies.SOLVER_KINDS),
    "strut": (vocabulary.STRUT_OUTPUTS, forces.STRUT_KINDS),
    "six by six": (vocabulary.SIX_BY_SIX_OUTPUTS, forces.SIX_BY_SIX_KINDS),
    "pose": (vocabulary.POSE_OUTPUTS | vocabulary.ROTATION_OUTPUTS, joints.POSE_KINDS),
}
PLAIN = [
    cls
    for cls in (*vars(joint_classes).values(), Prescribed)
    if isinstance(cls, type)
    and issubclass(cls, JointBase)
    and cls.kind
    and cls not in CONSTRAINTS + END_FRAMES
]


@pytest.mark.parametrize("what", TABLES)
def test_outputs_have_kinds_of_their_width(what):
    quantities, kinds = TABLES[what]
    assert set(quantities) == set(kinds)

    for name, kind in kinds.items():
        assert outputs.WIDTH.get(kind, 1) == quantities[name].width, name


def test_reactions_have_kinds_of_their_width():
    for name, reaction in vocabulary.REACTIONS.items():
        assert outputs.WIDTH[joints.REACTION_KINDS[name.removesuffix("_body")]] == reaction.width


def test_units_are_known():
    tables = [value for value in vars(vocabulary).values() if isinstance(value, dict)]
    quantities = [q for table in tables for q in table.values() if isinstance(q, vocabulary.Quantity)]
    coordinates = [value for value in vars(vocabulary).values() if isinstance(value, vocabulary.Coordinate)]
    quantities += [quantity for coordinate in coordinates for quantity in coordinate]
    assert len(quantities) > 80
    assert {quantity.unit for quantity in quantities} <= {None, *UNITS}


def test_every_joint_has_its_record():
    assert {cls.kind for cls in (*PLAIN, *CONSTRAINTS, *END_FRAMES)} == set(JOINT_KINDS)


@pytest.mark.parametrize("cls", PLAIN, ids=lambda cls: cls.kind)
def test_a_joint_names_the_coordinates_that_its_motions_have(cls):
    motions = JOINT_KINDS[cls.kind].motions

    if JOINT_KINDS[cls.kind].is_pose:
        (motion,) = motions
        assert sum(coordinate.position.width for coordinate in cls.coordinates) == N_Q[KINDS[motion]]
        assert sum(coordinate.rate.width for coordinate in cls.coordinates) == N_V[KINDS[motion]]
        return

    units = {"revolute": ("rad", "rad/s", "N.m"), "prismatic": ("m", "m/s", "N")}
    named = [tuple(quantity.unit for quantity in scalar.coordinate) for scalar in scalars(cls)]
    assert named == [units[motion] for motion in motions if motion in units]


@pytest.mark.parametrize("cls", [*CONSTRAINTS, *END_FRAMES], ids=lambda cls: cls.kind)
def test_what_only_constrains_has_no_coordinates(cls):
    assert cls.coordinates == ()
    assert not kind_of(cls).in_trees
