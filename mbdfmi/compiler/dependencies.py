"""Which inputs act on an output at the same instant."""

import itertools

from ..kernels import outputs


class Dependencies:
    """Of a model in the making (a Builder): asked output by output, those that feel the same share one tuple.

    An island is what joints and constraints hold together; `reach` is what force elements hold together as well.
    """

    def __init__(self, builder):
        self._island = islands(builder.nodes, builder.constraint_nodes + builder.shared_nodes)
        self._reach = islands(builder.nodes, builder.constraint_nodes + builder.force_nodes)
        # islands -> positions in u of the inputs that move them, that move what force elements hold to them, that pull at them
        moving = [(k, given.nodes) for k, given in enumerate(builder.inputs) if given.moves]
        pulling = [(k, given.nodes) for k, given in enumerate(builder.inputs) if not given.moves]
        self._moving = _by_island(self._island, moving)
        self._moving_far = _by_island(self._reach, moving)
        self._pulling = _by_island(self._island, pulling)
        self._found = {}

    def of(self, output) -> tuple[int, ...]:
        """Positions in u of the inputs that act on an Output, ascending.

        Accelerations and reactions feel all inputs at once that act on the same island, others only those that move it; what
        moves an island changes the forces between it and others.
        """
        led = output.nodes | output.moved_by

        if output.kind in outputs.ACCELERATES:
            felt = _felt(self._moving_far, self._reach, led)
            felt += _felt(self._pulling, self._island, output.nodes)
        else:
            felt = _felt(self._moving, self._island, led)

        key = (output.fed_by, *sorted(map(id, felt)))

        if key not in self._found:
            self._found[key] = tuple(sorted(set(output.fed_by).union(*felt)))

        return self._found[key]


def _by_island(island, inputs):
    """Island -> the inputs that act on it; inputs: (position in u, the nodes that it acts on)."""
    found = {}

    for k, nodes in inputs:
        for i in nodes:
            found.setdefault(island[i], set()).add(k)

    return found


def _felt(inputs, island, nodes):
    """The sets of inputs by island that act on some nodes."""
    return [inputs[k] for k in {island[i] for i in nodes} if k in inputs] if inputs else []


def islands(nodes, groups):
    """For each node the number of its island: what joints and groups of nodes hold together, the ground left out."""
    links = [(i, node.parent) for i, node in enumerate(nodes)]
    moving = [[i for i in group if i > 0] for group in [*links, *groups]]
    return joined(len(nodes), (pair for group in moving for pair in itertools.pairwise(group)))


def joined(n, pairs):
    """For each of n things the first of those that pairs join it to."""
    first = list(range(n))

    def find(i):
        while first[i] != i:
            first[i] = i = first[first[i]]

        return i

    for i, j in pairs:
        i, j = find(i), find(j)
        first[max(i, j)] = min(i, j)

    return [find(i) for i in range(n)]
