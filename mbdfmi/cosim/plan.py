"""Which master a system gets: of what was asked for and of what its FMUs can do."""

from __future__ import annotations

from dataclasses import dataclass, field

from .errors import CouplingError
from .graph import links_of_fmus, sequence
from .network import Network
from .schema import Master

ORDERS = {"jacobi": 0, "gauss-seidel": 0, "iterate": 1, "newton": 1}


@dataclass(frozen=True)
class Group:
    """FMUs that advance together by one method. loop : whether they feed each other in a circle."""

    names: list[str]
    method: str
    loop: bool


@dataclass
class Plan:
    """How a run is done.

    order : of the polynomials that inputs are; predicts : FMUs whose outputs are continued by them beyond the last known
    values. reasons : what was chosen and why, in words.
    """

    groups: list[Group]
    order: int
    predicts: set[str]
    reasons: list[str] = field(default_factory=list)

    @property
    def rolling(self) -> set[str]:
        """FMUs whose steps are repeated."""
        return {n for g in self.groups if g.method in ("iterate", "newton") for n in g.names}


def plan(net: Network, master: Master, without: frozenset[str] = frozenset()) -> Plan:
    """The plan of a run; without : FMUs whose rollback turned out to be of no use. Raises CouplingError."""
    unknown = [name for name in master.sequence if name not in net.names]
    if unknown:
        raise CouplingError(f"[master] sequence: no FMU {unknown[0]!r}; there are {', '.join(net.names)}")

    if twice := [name for k, name in enumerate(master.sequence) if name in master.sequence[:k]]:
        raise CouplingError(f"[master] sequence: {twice[0]!r} is there twice")

    rolls = {name for name, m in net.members.items() if m.can.rollback and name not in without}
    if master.error is not None and (cannot := [name for name in net.names if name not in rolls]):
        raise CouplingError(
            f"[master] error: macro steps are chosen by doing some again, and {', '.join(cannot)} cannot go back to a saved "
            "state, or must not; leave it out"
        )

    stiff = [name for name in net.names if not net.members[name].can.variable_steps]
    if master.error is not None and stiff:
        raise CouplingError(
            f"[master] error: {', '.join(stiff)} cannot take steps of different lengths; leave it out"
        )

    circles = sequence(net, master.sequence)
    edges = links_of_fmus(net)
    loops = [len(group) > 1 or (group[0], group[0]) in edges for group in circles]
    method = master.method

    if method == "jacobi":
        order = ORDERS[method] if master.order is None else master.order
        return Plan([Group(net.names, method, any(loops))], order, set(net.names) if order else set())

    if method == "gauss-seidel":
        order = ORDERS[method] if master.order is None else master.order
        names = [name for group in circles for name in group]
        if len(master.sequence) == len(net.names):
            names = list(master.sequence)
        reasons = [f"sequence: {', '.join(names)}"]
        return Plan([Group(names, method, any(loops))], order, set(names) if order else set(), reasons)

    if method in ("iterate", "newton"):
        for group, loop in zip(circles, loops):
            if loop and (cannot := [n for n in group if n not in rolls]):
                raise CouplingError(
                    f'[master] method "{method}": {cannot[0]} cannot go back to a saved state, or must not; write method = '
                    '"auto" or "gauss-seidel"'
                )

    groups, reasons = [], []
    predicts: set[str] = set()
    for names, loop in zip(circles, loops):
        groups += _groups(names, loop, rolls, method, master, predicts, reasons)

    repeated = any(g.method in ("iterate", "newton") for g in groups)
    order = master.order if master.order is not None else (1 if repeated else 0)
    if master.order:
        predicts |= set(net.names)
    return Plan(groups, order, predicts if order else set(), reasons)


def _groups(names, loop, rolls, method, master, predicts, reasons):
    """The groups that a circle of FMUs, or one alone, makes."""
    if not loop:
        return [Group(names, "gauss-seidel", False)]

    method = "newton" if method == "auto" else method
    cannot = [name for name in names if name not in rolls]

    if not cannot and master.order != 0:
        predicts |= set(names)
        reasons.append(f'{", ".join(names)}: feed each other, steps are repeated ("{method}")')
        return [Group(names, method, True)]

    rest = [name for name in names if name in rolls]
    if len(rest) < 2 or master.order == 0:
        reasons.append(
            f"{', '.join(names)}: feed each other and {', '.join(cannot) or 'order = 0'} "
            "cannot repeat steps, so one after another"
        )
        return [Group(names, "gauss-seidel", True)]

    predicts |= set(rest)
    reasons.append(
        f"{', '.join(cannot)}: cannot repeat steps, so before the others of the circle; {', '.join(rest)}: steps are "
        f'repeated ("{method}")'
    )
    return [Group(cannot, "gauss-seidel", True), Group(rest, method, True)]
