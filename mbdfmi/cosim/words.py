"""What is told of a system before it runs: FMUs, links, loops, order, master."""

from __future__ import annotations

from .errors import CouplingError
from .graph import circle_text, feed_edges, links_of_fmus, sequence, through
from .members import Member
from .network import Feed, Network, start_values
from .plan import Plan, plan
from .schema import SystemData
from .start import loops
from .trial import candidates_of
from .watch import bonds

MOST = 12
"""Entries of a list that are written out."""


def told(data: SystemData, members: dict[str, Member], net: Network) -> str:
    """The system in words. Raises CouplingError for parameters that cannot be set."""
    errors: list[str] = []
    for member in members.values():
        try:
            start_values(member)
        except CouplingError as error:
            errors += error.errors
    if errors:
        raise CouplingError(errors)

    chosen = plan(net, data.master)
    parts = [
        _fmus(members, net),
        _links(net),
        _graph(net, data),
        _loops("algebraic loops at the start, solved by Newton's method", net, True),
        _loops(
            "algebraic loops in the run: steps that are repeated solve them, others are a step late",
            net,
            False,
        ),
        _bonds(net, data),
        _master(chosen, data, net),
    ]
    return "\n\n".join(filter(None, parts))


def _fmus(members, net):
    lines = ["FMUs"]
    for name, member in members.items():
        kind = "scene" if member.model is not None else f"FMI {member.description.fmiVersion}"
        lines.append(
            f"  {name}: {kind}, {member.description.modelName}; {', '.join(member.can.words()) or 'no capability'}"
        )
        pairs = through(net, name)
        if not member.is_told and pairs:
            lines.append("    does not tell what its outputs depend on: taken for all inputs")
        elif pairs:
            lines.append(f"    at once: {_some(f'{a} -> {b}' for a, b in pairs)}")
        fed = {feed.entry.name for feed in [*net.feeds, *net.discrete] if feed and feed.taker == name}
        idle = [s.name for s in member.signals.values() if s.causality == "input" and s.name not in fed]
        if idle:
            lines.append(f"    inputs that nothing feeds: {_some(idle)}")
    return "\n".join(lines)


def _links(net):
    feeds = [feed for feed in net.feeds if feed] + net.discrete
    return "\n".join(["links", *("  " + _link(feed) for feed in feeds)]) if feeds else "no links"


def _link(feed: Feed):
    factors = [term.factor for term in feed.terms]
    more = []
    if any(factor != 1.0 for factor in factors):
        more.append("times " + ", ".join(f"{factor:.6g}" for factor in factors))
    if feed.offset:
        more.append(f"plus {feed.offset:.6g}")
    more += dict.fromkeys(feed.notes)
    return feed.text + (f" ({'; '.join(more)})" if more else "")


def _graph(net, data):
    edges = links_of_fmus(net)
    lines = ["order"]
    for group in sequence(net, data.master.sequence):
        circle = len(group) > 1 or (group[0], group[0]) in edges
        lines.append("  " + ", ".join(group) + (" (they feed each other)" if circle else ""))
    return "\n".join(lines)


def _loops(title, net, at_start):
    found = loops(net, at_start)
    if not found:
        return ""
    following: dict[Feed, list[Feed]] = {}
    for a, b in feed_edges(net, at_start):
        following.setdefault(a, []).append(b)
    return "\n".join([title, *("  " + circle_text(group, following) for group in found)])


def _bonds(net, data):
    found = bonds(net, data.bond)
    if not found:
        return "power is watched at no link: no force and velocity of one place go one each way, by links of one source each"
    return "\n".join(["power is watched at", *(f"  {b.effort.text}  and  {b.flow.text}" for b in found)])


def _master(chosen: Plan, data: SystemData, net):
    lines = ["master"]
    words = {
        "jacobi": "all at once",
        "gauss-seidel": "one after another",
        "iterate": "steps repeated until all agree (fixed point)",
        "newton": "steps repeated until all agree (interface Jacobian)",
    }
    lines += [
        f"  {', '.join(g.names)}: {words[g.method] if len(g.names) > 1 else 'alone'}" for g in chosen.groups
    ]
    lines += [f"  {reason}" for reason in chosen.reasons]
    if any(len(candidates_of(net, group, data.master)) > 1 for group in chosen.groups):
        lines.append("  other sequences are tried in the first steps of a run, and the best is taken")
    constant = [n for n in net.names if not net.members[n].can.input_derivatives and net.fed[n].n]
    if chosen.order:
        lines.append(f"  inputs are polynomials of order {chosen.order} over a step")
    if constant and (chosen.order or any(g.method != "jacobi" for g in chosen.groups)):
        lines.append(f"  held over a step, as they take no derivatives: inputs of {', '.join(constant)}")
    if data.master.error is not None:
        lines.append(f"  macro steps chosen for an error of {data.master.error:g}")
    return "\n".join(lines)


def _some(words):
    words = list(words)
    return ", ".join(words[:MOST]) + (f" and {len(words) - MOST} more" if len(words) > MOST else "")
