"""Who waits for whom: the order of FMUs, circles of them, and circles of outputs that depend on inputs at once."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping, Sequence
from graphlib import TopologicalSorter

import numpy as np
import scipy

from .network import Feed, Network


def components(nodes: Sequence[Hashable], edges: Iterable[tuple[Hashable, Hashable]]) -> list[list]:
    """Nodes by circles (strongly connected components), each behind those that it depends on; in a circle, and where
    nothing else decides, in the order of `nodes`.

    edges : (from, to): `to` depends on `from`.
    """
    place = {node: k for k, node in enumerate(nodes)}
    pairs = [(place[a], place[b]) for a, b in edges]
    n = len(place)
    # old scipy finds components of short indices alone
    rows, columns = np.array(pairs, np.int32).reshape(-1, 2).T
    matrix = scipy.sparse.csr_array((np.ones(len(pairs)), (rows, columns)), shape=(n, n))
    _, label = scipy.sparse.csgraph.connected_components(matrix, directed=True, connection="strong")

    # circles by their first node, so that what is independent stays in its order
    members: dict[int, list] = {}
    for node, k in place.items():
        members.setdefault(int(label[k]), []).append(node)

    before: dict[int, set[int]] = {circle: set() for circle in members}
    for a, b in pairs:
        if label[a] != label[b]:
            before[int(label[b])].add(int(label[a]))

    sorter = TopologicalSorter(before)
    sorter.prepare()
    rank = {circle: place[group[0]] for circle, group in members.items()}
    found, ready = [], []

    while sorter.is_active():
        ready += sorter.get_ready()
        ready.sort(key=rank.__getitem__)
        circle = ready.pop(0)
        found.append(members[circle])
        sorter.done(circle)

    return found


def links_of_fmus(net: Network) -> list[tuple[str, str]]:
    """(giver, taker) of all links."""
    feeds = [feed for feed in net.feeds if feed] + net.discrete
    return list(dict.fromkeys((term.giver, feed.taker) for feed in feeds for term in feed.terms))


def feed_edges(net: Network, at_start: bool) -> list[tuple[Feed, Feed]]:
    """(earlier, later): the source of the later one depends at once on the input that the earlier one feeds."""
    feeds = [feed for feed in net.feeds if feed] + net.discrete
    fed: dict[str, dict[str, Feed]] = {name: {} for name in net.names}
    for feed in feeds:
        fed[feed.taker][feed.entry.name] = feed

    edges = []
    for later in feeds:
        for term in later.terms:
            told = net.members[term.giver].depends(term.output, at_start)
            own = fed[term.giver]
            edges += [(own[name], later) for name in (own if told is None else told) if name in own]
    return edges


def through(net: Network, name: str) -> list[tuple[str, str]]:
    """(input, output) of an FMU's linked signals where the output depends on the input at once."""
    member = net.members[name]
    inputs = [feed.entry.name for feed in [*net.feeds, *net.discrete] if feed and feed.taker == name]
    outputs = [*net.read[name].signals, *net.others[name].signals]
    found = []
    for output in outputs:
        told = member.depends(output)
        found += [(entry, output.name) for entry in inputs if told is None or entry in told]
    return found


def sequence(net: Network, wanted: Sequence[str] = ()) -> list[list[str]]:
    """FMUs by circles, in the order in which they should advance; `wanted` ones first within a circle.

    Within a circle an FMU whose outputs depend on its inputs at once comes behind those that feed it: so what it hands
    out at the end of a step is of that end.
    """
    edges = links_of_fmus(net)
    names = [*wanted, *(name for name in net.names if name not in wanted)]
    return [_within(net, group, edges, wanted) for group in components(names, edges)]


def _within(net, group, edges, wanted):
    if (len(group) < 3 and wanted) or len(group) == 1:
        return group
    told = [name for name in group if name in wanted]
    rest = [name for name in group if name not in wanted]
    late = {name for name in rest if through(net, name)}
    first = [name for name in rest if name not in late]
    inner = [(a, b) for a, b in edges if a in late and b in late and a != b]
    return (
        told
        + first
        + [name for circle in components([n for n in rest if n in late], inner) for name in circle]
    )


def circle_text(group: Sequence[Feed], edges: Mapping[Feed, Sequence[Feed]]) -> str:
    """A circle of links, as messages name it: one way around."""
    inside, path = set(group), [group[0]]

    while True:
        following = next(feed for feed in edges[path[-1]] if feed in inside)
        if following in path:
            path = path[path.index(following) :]
            break
        path.append(following)

    parts = [f"{feed.taker}.{feed.entry.name}" for feed in path]
    outputs = [
        next(t for t in after.terms if t.giver == feed.taker)
        for feed, after in zip(path, [*path[1:], path[0]])
    ]
    words = [f"{part} -> {term.giver}.{term.output.name}" for part, term in zip(parts, outputs)]
    return " -> ".join([*words, parts[0]])
