"""Orders of elimination that keep factors of sparse matrices sparse."""

from heapq import heapify, heappop, heappush


def elimination(neighbours):
    """An order of elimination with little fill, and the neighbours of each unknown before it.

    neighbours : for each the set of those that it is coupled with. Minimum degree: next comes the one with the fewest
    neighbours left, which then all become neighbours. Returns (order, for each in the order its earlier neighbours, as places
    in the order). The same on every machine, as the numbers that come of it must be.
    """
    left = [set(near) for near in neighbours]
    done = [False] * len(left)
    order = []
    earlier = [[] for _ in left]
    heap = [(len(near), k) for k, near in enumerate(left)]
    heapify(heap)

    while heap:
        count, c = heappop(heap)

        # only the latest entry of each counts
        if done[c] or count != len(left[c]):
            continue

        done[c] = True

        for k in left[c]:
            earlier[k].append(len(order))
            left[k] |= left[c]
            left[k] -= {k, c}
            heappush(heap, (len(left[k]), k))

        order.append(c)

    return order, [earlier[c] for c in order]


def neighbours(paths):
    """For each path of nodes the set of the others that share a node with it."""
    at_node = {}

    for c, path in enumerate(paths):
        for i in path:
            at_node.setdefault(i, set()).add(c)

    near = [set() for _ in paths]

    for group in at_node.values():
        for c in group:
            near[c] |= group

    return [near[c] - {c} for c in range(len(paths))]
