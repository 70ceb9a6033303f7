"""Springs and dampers, by a constant or by table."""

from typing import NamedTuple

import numpy as np

from ..kernels import outputs
from ..kernels.math.tables import LINEAR
from .builder import Place, Source
from .interpolation import curve
from .variables import dotted


class Spring(NamedTuple):
    """table : index, -1 without. rest : where its energy is zero, None: as at the start."""

    table: int
    stiffness: float
    rest: float | None

    @property
    def is_linear(self) -> bool:
        """Whether it goes by stiffness and rest."""
        return self.table < 0


class Damper(NamedTuple):
    """table : index, -1 without."""

    table: int
    damping: float


def spring_of(builder, graph, stiffness, rest):
    """A spring of an effort over a position or length, or without that of a stiffness."""
    if graph is None:
        return Spring(-1, stiffness, rest)

    table, rest = _elastic_table(builder, graph)
    return Spring(table, 0.0, rest)


def damper_of(builder, given):
    """A damper of a number, or of a table of effort over speed."""
    if isinstance(given, float):
        return Damper(-1, given)

    return Damper(_elastic_table(builder, given.table)[0], 0.0)


def add_along(builder, name, coordinate, spring, damper, units, key):
    """A spring (or None) and a damper along a coordinate, with parameters of `name`; returns their row.

    units : of the coordinate and of efforts along it. key : what the damper's parameter is called.
    """
    unit, effort = units
    linear = spring is not None and spring.is_linear
    spring = spring or Spring(-1, 0.0, 0.0)
    row = builder.tables["n_joint_spring"].add(
        joint_spring_coordinate=coordinate,
        joint_spring_table=spring.table,
        joint_damper_table=damper.table,
        joint_stiffness=spring.stiffness,
        joint_rest=spring.rest,
        joint_damping=damper.damping,
    )
    watch(
        builder,
        name,
        unit,
        Source(outputs.COORDINATE, coordinate),
        Source(outputs.RATE, coordinate),
        spring,
        damper,
    )

    if linear:
        about, place = f"stiffness of {name}", Place("joint_stiffness", row)
        builder.add_parameters(dotted(name, "stiffness"), place, spring.stiffness, f"{effort}/{unit}", about)
        about, place = f"position of {name} at which its spring is slack", Place("joint_rest", row)
        builder.add_parameters(dotted(name, "rest"), place, spring.rest, unit, about)

    if damper.damping:
        about, place = f"damping of {name}", Place("joint_damping", row)
        builder.add_parameters(dotted(name, key), place, damper.damping, f"{effort}.s/{unit}", about)

    return row


def watch(builder, name, unit, length, rate, spring, damper):
    """Watch for kinks of a spring's table over a coordinate or length (a Source), and of a damper's over its rate."""
    builder.watch(dotted(name, "spring"), unit, length, spring.table)
    builder.watch(dotted(name, "damper"), f"{unit}/s", rate, damper.table)


def _elastic_table(builder, graph):
    """(index of the table of an effort over a position, length or rate, where a spring's energy is zero).

    Straight beyond the ends. The energy is zero at the first point where the effort is, else at the table's first point.
    """
    x, effort = graph.points()
    effort = curve(graph.interpolation, x, effort)
    slack = [root for root in effort.solve(0.0, extrapolate=False) if np.isfinite(root)]
    return builder.table(effort, LINEAR), float(min(slack, default=x[0]))
