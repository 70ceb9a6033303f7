"""What depends on what in x' = f(x): the blocks of J = dx'/dx, and how Newton matrices mu 1 - J are factored.

Joints that hang together in the tree, or by constraints, accelerate together: their velocities are one block, an *island*. Forces
couple islands. A joint's position coordinates are a block of their own: their rates follow from them and the joint's velocities
alone. Eliminated first they make no fill, so that what is left to be factored has the size of the velocities.

Blocks stand in an order of elimination; their values by rows, in `jacobian` and in the factors (kernels/math/linear.py). Columns of
blocks that no row shares are found in one evaluation (kernels/steppers/jacobian.py).
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..kernels.joints import N_Q, N_V
from ..kernels.motion import coordinates
from .elimination import elimination


@dataclass
class Block:
    """Unknowns that are eliminated together: where they stand in x; the islands that their rates depend on, and the nodes: of
    positions the one that has them, of an angle outside the tree those whose positions it depends on.
    """

    unknowns: list[int]
    islands: set[int] = field(default_factory=set)
    nodes: list[int] = field(default_factory=list)


class Element(NamedTuple):
    """The part of a row of blocks that lies in column block `block`: columns from `first` on, `width` of them."""

    block: int
    first: int
    width: int


class Structure(NamedTuple):
    """tables: rows of the layout's arrays, by their count; single: arrays by name; n_value: values of a matrix; products: of numbers,
    that a real factor costs."""

    tables: dict[str, list[dict]]
    single: dict[str, list[int]]
    n_value: int
    products: int

    @property
    def n_evaluation(self) -> int:
        """Evaluations that a Jacobian costs."""
        return sum(row["colour_width"] for row in self.tables["n_colour"])


def find_structure(values, n_body, n_q, n_v, n_s, n_turn) -> Structure:
    """The structure of a model's Jacobian; values: its arrays by name."""
    parts = _Parts(values, n_body, n_q + n_v, n_s, n_turn)
    blocks = _turn_blocks(parts, n_q + n_v + n_s, n_turn) + parts.still_memories
    n_free = len(blocks)
    blocks += _position_blocks(parts)
    order, earlier = elimination(parts.coupled)
    first_island = len(blocks)
    place = {island: first_island + k for k, island in enumerate(order)}
    blocks += [Block(parts.unknowns(island, n_q)) for island in order]
    rows, sparse = _rows(parts, blocks, n_free, place, earlier)
    return _laid_out(blocks, rows, sparse, n_free)


class _Parts:
    """Islands of a model's nodes, and which of them forces couple."""

    def __init__(self, values, n_body, first_s, n_s, n_turn):
        self.values = values
        self.first_s = first_s
        self.kind = np.ravel(values["body_joint"]).astype(int)
        self.q, self.v = (np.ravel(values[name]).astype(int) for name in ("body_q", "body_v"))
        self.still = self._still(n_body)
        self._leader = list(range(n_body))
        self._join_all(n_body)
        leaders = [self._find(i) for i in range(1, n_body) if N_V[self.kind[i]] or N_Q[self.kind[i]]]
        self.index = {leader: k for k, leader in enumerate(dict.fromkeys(leaders))}
        self.n_q = {i: N_Q[self.kind[i]] for i in range(1, n_body)}
        self.n_v = {i: N_V[self.kind[i]] for i in range(1, n_body)}
        self.members = [[] for _ in self.index]
        self.first = {}
        size = [0] * len(self.index)

        for i in range(1, n_body):
            if self.n_v[i]:
                island = self.island(i)
                self.members[island].append(i)
                self.first[i] = size[island]
                size[island] += self.n_v[i]

        self.parameters = self._parameters(n_s)
        self._add_memories(n_s + n_turn)
        self.coupled = self._coupled()

    def _column(self, name):
        return np.ravel(np.asarray(self.values.get(name, ()), dtype=int)) if name in self.values else []

    def _still(self, n_body):
        """Nodes that move as they are told to, whatever the others do: the ground, and what is driven on such."""
        still = [True] + [False] * (n_body - 1)

        for i, (parent, drive) in enumerate(zip(self._column("body_parent"), self._column("body_drive"))):
            still[i] = i == 0 or (still[parent] and (drive >= 0 or not N_V[self.kind[i]]))

        return still

    def _find(self, i):
        while self._leader[i] != i:
            self._leader[i] = self._leader[self._leader[i]]
            i = self._leader[i]

        return i

    def _join(self, nodes):
        """Nodes accelerate together."""
        leaders = sorted({self._find(i) for i in nodes if not self.still[i]})

        for other in leaders[1:]:
            self._leader[other] = leaders[0]

    def _join_all(self, n_body):
        parent = self._column("body_parent")
        paths = self._column("path_node")

        for i in range(1, n_body):
            self._join((i, parent[i]))

        for first, count in zip(self._column("constraint_path"), self._column("constraint_paths")):
            self._join(paths[first : first + count])

        for a, b in zip(self._column("end_frame_a"), self._column("end_frame_b")):
            self._join(self._bodies(a, b))

        for k, adds in enumerate(self._column("six_by_six_adds")):
            if adds:
                self._join(self._bodies(self.values["six_by_six_from"][k], self.values["six_by_six_to"][k]))

        for k in zip(self._column("shared_from"), self._column("shared_to")):
            self._join(self._bodies(*k))

    def _bodies(self, *markers):
        """Nodes of markers, -1 being none."""
        of = self._column("marker_body")
        return [of[int(np.ravel(k)[0])] for k in markers if np.ravel(k)[0] >= 0]

    def island(self, i):
        """Island of a node."""
        return self.index[self._find(i)]

    def islands(self, nodes):
        """Those of nodes that move freely."""
        return {self.island(i) for i in nodes if not self.still[i]}

    def unknowns(self, island, n_q):
        """Where the velocities of an island, and the parameters of its end frames, stand in x."""
        v = [n_q + self.v[i] + k for i in self.members[island] for k in range(self.n_v[i])]
        return v + [self.first_s + s for s in self.parameters[island]]

    def _parameters(self, n_s):
        """Parameters of end frames in each island."""
        found = [[] for _ in self.index]
        starts = [*self._column("end_frame_z"), n_s]
        ends = zip(self._column("end_frame_a"), self._column("end_frame_b"))

        for k, (a, b) in enumerate(ends):
            islands = sorted(self.islands(self._bodies(a, b))) or [0]
            found[islands[0]] += range(starts[k], starts[k + 1])

        return found

    def _add_memories(self, first):
        """Memories of the waves that bodies make, each to its bodies' island, or by itself where these move as they are told to.

        first : where they stand behind the parameters.
        """
        columns = ("radiation_marker", "radiation_memory", "radiation_memories")
        self.still_memories = []

        markers = {}

        for marker, begin, count in zip(*(self._column(name) for name in columns)):
            markers.setdefault((begin, count), []).append(marker)

        for (begin, count), ends in markers.items():
            states = range(first + begin, first + begin + count)
            islands = self.islands(self._bodies(*ends))

            for island in islands:
                self.parameters[island] += states

            if not islands:
                self.still_memories.append(Block([self.first_s + k for k in states]))

    def coordinate_ends(self, k):
        """Nodes that coordinate k outside the tree is between."""
        return self._bodies(self.values["coordinate_from"][k], self.values["coordinate_to"][k])

    def below(self, nodes):
        """Nodes with positions on the way from some to the ground, ascending."""
        parent = self._column("body_parent")
        found = set()

        for i in nodes:
            while i > 0 and i not in found:
                found.add(int(i))
                i = parent[i]

        return sorted(i for i in found if self.n_q[i])

    def _coupled(self):
        """For each island the set of others that forces couple it with."""
        groups = [
            self._bodies(*markers)
            for names in (
                ("strut_from", "strut_to"),
                ("six_by_six_from", "six_by_six_to"),
                ("wrench_marker", "wrench_reaction", "wrench_axes"),
                ("load_marker", "load_axes"),
                ("line_from", "line_to"),
            )
            for markers in zip(*(self._column(name) for name in names))
        ]
        kinds = self._column("coordinate_kind")
        groups += [self.coordinate_ends(k) for k, kind in enumerate(kinds) if kind != coordinates.IN_TREE]
        coupled = [set() for _ in self.index]

        for group in groups:
            islands = self.islands(group)

            for island in islands:
                coupled[island] |= islands - {island}

        return coupled


def _turn_blocks(parts, first, n_turn):
    """Angles outside the tree: nothing depends on them (but through their turns), they on the islands that they are between,
    and there on the positions of the nodes below them alone.
    """
    of = parts._column("turn_coordinate")
    ends = [parts.coordinate_ends(of[t]) for t in range(n_turn)]
    return [Block([first + t], parts.islands(group), parts.below(group)) for t, group in enumerate(ends)]


def _position_blocks(parts):
    """The position coordinates of each node."""
    return [
        Block([parts.q[i] + k for k in range(n)], {parts.island(i)}, [i]) for i, n in parts.n_q.items() if n
    ]


def _rows(parts, blocks, n_free, place, earlier):
    """(elements of each row of blocks, ascending; of each how many blocks of columns it has before fill)."""
    first_island = len(blocks) - len(place)
    of_island = [[] for _ in place]
    of_node = {}

    for b in range(n_free, first_island):
        of_island[min(blocks[b].islands)].append(b)
        of_node[blocks[b].nodes[0]] = b

    def whole(b):
        return Element(b, 0, len(blocks[b].unknowns))

    rows, sparse = [], []

    for b, block in enumerate(blocks[:first_island]):
        row = [whole(b)]

        if b < n_free:
            row += [whole(of_node[node]) for node in block.nodes]
            row += [whole(place[island]) for island in block.islands]
        else:
            node, island = block.nodes[0], min(block.islands)
            row += [Element(place[island], parts.first[node], parts.n_v[node])] if parts.n_v[node] else []

        rows.append(sorted(row))
        sparse.append({element.block for element in row})

    later = [set() for _ in place]

    for k, before in enumerate(earlier):
        for e in before:
            later[e].add(k)

    for k, island in enumerate(place):
        near = {island} | parts.coupled[island]
        seen = {b for other in near for b in of_island[other]} | {place[other] for other in near}
        filled = seen | {first_island + e for e in [*earlier[k], *later[k]]}
        rows.append([whole(b) for b in sorted(filled)])
        sparse.append(seen)

    return rows, sparse


def _colours(blocks, columns, n_free):
    """Blocks in groups of which no row has two, greedily, large ones first. columns: of each block the rows that it is in."""
    groups = []
    colours = [set() for _ in blocks]

    for b in sorted(range(n_free, len(blocks)), key=lambda b: (-len(blocks[b].unknowns), blocks[b].unknowns)):
        taken = set().union(*(colours[row] for row in columns[b]))
        colour = next(k for k in range(len(groups) + 1) if k not in taken)

        if colour == len(groups):
            groups.append([])

        groups[colour].append(b)

        for row in columns[b]:
            colours[row].add(colour)

    return groups


def _laid_out(blocks, rows, sparse, n_free):
    """The arrays of all that."""
    tables = {"n_block": [], "n_element": [], "n_column": [], "n_colour": [], "n_member": []}
    size = [len(block.unknowns) for block in blocks]
    columns = [{} for _ in blocks]
    place = value = 0

    for b, row in enumerate(rows):
        first = len(tables["n_element"])

        for element in row:
            if element.block in sparse[b]:
                columns[element.block][b] = len(tables["n_element"])

            tables["n_element"].append(
                dict(
                    element_block=element.block,
                    element_first=element.first,
                    element_width=element.width,
                    element_value=value,
                )
            )
            value += size[b] * element.width

        own = first + [element.block for element in row].index(b)
        tables["n_block"].append(
            dict(
                block_place=place,
                block_size=size[b],
                block_element=first,
                block_elements=len(row),
                block_own=own,
            )
        )
        place += size[b]

    for b, entries in enumerate(columns):
        tables["n_block"][b] |= dict(block_column=len(tables["n_column"]), block_columns=len(entries))
        tables["n_column"] += [dict(column_row=row, column_element=e) for row, e in sorted(entries.items())]

    for group in _colours(blocks, columns, n_free):
        tables["n_colour"].append(
            dict(
                colour_member=len(tables["n_member"]),
                colour_members=len(group),
                colour_width=max(size[b] for b in group),
            )
        )
        tables["n_member"] += [dict(member_block=b) for b in group]

    single = {"place_x": [x for block in blocks for x in block.unknowns]}
    return Structure(tables, single, value, _products(rows, size))


def _products(rows, size):
    """Products of numbers that a real factor costs."""
    total = 0

    for b, row in enumerate(rows):
        total += size[b] ** 3 // 3

        for element in row:
            k = element.block

            if k < b:
                total += size[b] * size[k] ** 2
                total += size[b] * size[k] * sum(e.width for e in rows[k] if e.block > k)

    return total
