"""How mooring lines hang: points along them, by the pull that kernels find for the distances of their ends.

The equations are in docs/theory.md 16.15.
"""

from typing import NamedTuple

import numpy as np

from ..kernels.forces import catenaries, composite_pulls, composite_shapes

# of a line's weight: H below is none
LEAST = composite_shapes.LEAST

# of a line's length: a gap at its second end that is more than rounding
GAP = 1e-9


class Line(NamedTuple):
    """Line k of a kind in a model's arrays; composite: of several sections, or with friction of the bed."""

    composite: bool
    k: int

    def markers(self, m):
        """Its first end's marker and its second's."""
        ends = (m.composite_from, m.composite_to) if self.composite else (m.line_from, m.line_to)
        return int(ends[0][self.k]), int(ends[1][self.k])

    def has_bed(self, m):
        """Whether it may lie on a bed, as high as its first end."""
        return bool((m.composite_bed if self.composite else m.line_bed)[self.k])

    def sections(self, m):
        """Of each section: length (m), weight in water (N/m), EA (N), what hangs at its upper end (N)."""
        g = -m.gravity[2]

        if not self.composite:
            k = slice(self.k, self.k + 1)
            return m.line_length[k], g * m.line_mass[k], m.line_stiffness[k], np.zeros(1)

        first = int(m.composite_section[self.k])
        k = slice(first, composite_shapes.last_section(m, self.k) + 1)
        return m.section_length[k], g * m.section_mass[k], m.section_stiffness[k], g * m.section_clump[k]


def lines_of(scene) -> dict[str, Line]:
    """The lines of a scene by name: each kind is numbered by itself."""
    rows, count = {}, [0, 0]

    for name, force in scene.force.items():
        if force.kind == "catenary":
            composite = force.catenary.is_composite
            rows[name] = Line(composite, count[composite])
            count[composite] += 1

    return rows


class Hanging(NamedTuple):
    """A line with its ends at n distances, in p pieces one after another from its first end on.

    x, z : (n,) m, across and up to the second end. H, V : (n,) N, towards the first end and down: the pull
        on the second. weight (N/m), stiffness (N), lies, section : (p,), of pieces. length : (n, p) m,
        unstretched. bottom : (n, p) N, downwards, at a hanging piece's end towards the first end. held :
        (n, p) N, by which a lying one is stretched.
    """

    x: np.ndarray
    z: np.ndarray
    H: np.ndarray
    V: np.ndarray
    weight: np.ndarray
    stiffness: np.ndarray
    lies: np.ndarray
    length: np.ndarray
    bottom: np.ndarray
    held: np.ndarray
    section: np.ndarray

    @property
    def grounded(self):
        """(n,) m, that lies on the bed."""
        return self.length[:, self.lies].sum(axis=1)


def hang(m, d, line, x, z) -> Hanging:
    """Line as it hangs with its second end x >= 0 across and z up from its first, (n,) m each."""
    x, z = (np.atleast_1d(np.asarray(v, float)) for v in (x, z))
    return (_composite if line.composite else _single)(m, d, line, x, z)


def _single(m, d, line, x, z):
    """One section: what lies, what hangs."""
    k, bed = line.k, line.has_bed(m)
    (L,), (w,), (EA,), _ = line.sections(m)

    # without a bed the pull is that at the upper end
    swapped = (z < 0.0) & (not bed)
    H, V = np.array(
        [catenaries.pull(m, d, k, float(a), float(b)) for a, b in zip(x, np.where(swapped, -z, z))]
    ).T
    flat = np.maximum(L - V / w, 0.0) if bed else np.zeros(len(x))
    bottom = np.maximum(V - w * L, 0.0) if bed else np.where(swapped, -V, V - w * L)
    V = np.where(swapped, w * L - V, V)
    lies = np.array([True, False])
    return Hanging(
        x,
        z,
        H,
        V,
        np.array([w, w]),
        np.array([EA, EA]),
        lies,
        np.column_stack([flat, L - flat]),
        np.column_stack([np.zeros(len(x)), bottom]),
        np.column_stack([H, np.zeros(len(x))]),
        np.zeros(2, int),
    )


def _composite(m, d, line, x, z):
    """Several sections: of each what falls, lies, rises towards the second end."""
    k, first = line.k, int(m.composite_section[line.k])
    lengths, weights, stiffness, _ = line.sections(m)
    p = 3 * len(lengths)
    length, bottom, held = np.zeros((3, len(x), p))
    pulls = np.empty((2, len(x)))

    for row, (across, up) in enumerate(zip(x, z)):
        H, V = pulls[:, row] = composite_pulls.pull(m, d, k, float(across), float(up))

        for j in range(len(lengths)):
            floor, cap = composite_shapes.bounds(m, d, k, first + j, V)
            of = composite_shapes.parts(m, d, k, first + j, floor.at, cap.at, H, V)
            length[row, 3 * j : 3 * j + 3] = of.down, of.flat, of.up
            bottom[row, 3 * j : 3 * j + 3] = of.down_bottom, 0.0, of.up_bottom

            if of.flat > 0.0:
                # stretched by what it is pulled with, where it is tight
                tight = of.slid / of.flat
                held[row, 3 * j + 1] = (
                    0.5 * (of.pull + composite_shapes.pull_below(m, k, first + j, of)) * tight
                )

    return Hanging(
        x,
        z,
        pulls[0],
        pulls[1],
        np.repeat(weights, 3),
        np.repeat(stiffness, 3),
        np.tile([False, True, False], len(lengths)),
        length,
        bottom,
        held,
        np.repeat(np.arange(len(lengths)), 3),
    )


def points(of: Hanging, s) -> np.ndarray:
    """(n, k, 2) m, across and up from the first end, of places s ((k,) or (n, k) m, unstretched, from there).

    What is slack on a bed is drawn together to its width.
    """
    s = np.broadcast_to(np.asarray(s, float), (len(of.x), np.shape(s)[-1]))
    size = np.abs(of.weight * of.length).sum(axis=1)
    h = np.maximum(of.H, LEAST * size)[:, None]
    begin = np.cumsum(of.length, axis=1) - of.length
    whole = np.zeros((*s.shape, 2))
    flat, ends, lying = np.zeros(s.shape), np.zeros(len(of.x)), np.zeros(len(of.x))

    for j, lies in enumerate(of.lies):
        L, EA = of.length[:, j, None], of.stiffness[j]
        part = np.clip(s - begin[:, j, None], 0.0, L)

        if lies:
            share = 1.0 + of.held[:, j, None] / EA
            flat += share * part
            lying += (share * L)[:, 0]
        else:
            bottom = of.bottom[:, j, None]
            whole += np.stack(_hung(of.weight[j], part, EA, h, bottom), axis=2)
            ends += _hung(of.weight[j], L, EA, h, bottom)[0][:, 0]

    over = ends + lying - of.x
    slack = (over > GAP * of.length.sum(axis=1)) & (lying > 0.0)
    squeezed = np.where(slack, np.maximum(1.0 - over / np.where(slack, lying, 1.0), 0.0), 1.0)
    whole[:, :, 0] += squeezed[:, None] * flat
    return whole


def _hung(w, L, EA, h, bottom):
    """(x, z) m, of pieces of lengths L (m): kernels' `line_pieces.piece` for arrays, also of no length."""
    top = bottom + w * L
    s, s_b = np.hypot(h, top), np.hypot(h, bottom)
    product = top * bottom

    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        apart = h * h * (1.0 + (h * h + top * top + bottom * bottom) / (s * s_b - product))
        half = L / np.sqrt(2.0 * np.where(product >= 0.0, h * h + s * s_b + product, apart))
        q = w * half
        turned = 2.0 * half * np.where(q == 0.0, 1.0, np.arcsinh(q) / q)
        rise = L * (top + bottom) / (s + s_b)

    return h * turned + h * L / EA, rise + 0.5 * L * (top + bottom) / EA
