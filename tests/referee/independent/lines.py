"""Lines by nested bisection, and drag on members by adaptive quadrature."""

import itertools

import numpy as np
from scipy.integrate import quad_vec
from scipy.optimize import brentq

from .reading import cross


class Line:
    """An elastic line between two frames. sea : the scene's table of that, maybe empty. anchor : (owner, position, axes) of the
    first end."""

    kind = "catenary"

    def __init__(self, given, name, force, sea, anchor):
        spec = force["catenary"]
        self.name, self.ends = name, force["between"]
        displaced = sea.get("density", 1025.0) * np.pi * spec.get("diameter", 0.0) ** 2 / 4
        self.length = given(spec["length"], name, "length")
        self.mass = given(spec["mass"] - displaced, name, "mass")
        self.stiffness = given(spec["stiffness"], name, "stiffness")
        self.bed = spec.get("bed")

        if self.bed is None:
            (owner, position, _), depth = anchor, sea.get("depth")
            self.bed = owner in ("ground", "inertial") and (not depth or position[2] < -0.99 * depth)

    def reach(self, w, H, V):
        """(x, z) of the ends at a pull."""
        L, EA = self.length, self.stiffness
        on_bed = max(0.0, L - V / w) if self.bed else 0.0
        low = V - w * (L - on_bed)
        if H == 0.0:
            return on_bed, (abs(V) - abs(low)) / w + (V * V - low * low) / (2 * EA * w)
        x = on_bed * (1 + H / EA) + H / w * (np.arcsinh(V / H) - np.arcsinh(low / H)) + H * (L - on_bed) / EA
        return x, (np.hypot(H, V) - np.hypot(H, low)) / w + (V * V - low * low) / (2 * EA * w)

    def pull(self, w, x, z):
        """(H, V): for each H the V that rises to z, and the H that then spans x."""
        L, EA = self.length, self.stiffness

        if self.bed and z <= 0.0:
            return max(0.0, EA * (x / L - 1)), 0.0

        # more than either end ever pulls
        most = 10 * (w * L + EA * (1 + (x + abs(z)) / L))
        least = 0.0 if self.bed else -most
        lift = lambda H: brentq(lambda V: self.reach(w, H, V)[1] - z, least, most, xtol=1e-13, rtol=1e-15)
        span = lambda H: self.reach(w, H, lift(H))[0] - x

        if span(0.0) >= 0.0 if self.bed else span(1e-9 * w * L) >= 0.0:
            return 0.0, lift(0.0 if self.bed else 1e-9 * w * L)

        H = brentq(span, 0.0 if self.bed else 1e-9 * w * L, most, xtol=1e-13, rtol=1e-15)
        return H, lift(H)

    def forces(self, first, second, g):
        """{marker's side: force} on the first and second end (N), and what else is told. first, second : m."""
        w = self.mass * g
        flips = not self.bed and second[2] < first[2]
        low, high = (second, first) if flips else (first, second)
        x, z = np.hypot(*(high - low)[:2]), (high - low)[2]
        H, V = self.pull(w, x, z)
        along = (high - low) * [1, 1, 0] / x if x > 0 else np.zeros(3)
        bottom = V - w * self.length
        bottom = max(bottom, 0.0) if self.bed else bottom
        on_high, on_low = -H * along - [0, 0, V], H * along + [0, 0, bottom]
        on = (on_high, on_low) if flips else (on_low, on_high)
        on_bed = max(0.0, self.length - V / w) if self.bed else 0.0
        return on, on_bed, self.stored(w, H, V, low)

    def stored(self, w, H, V, low):
        """J: strain along the line, and weight by height over the bed, or over 0 without one."""
        L, EA = self.length, self.stiffness
        on_bed = max(0.0, L - V / w) if self.bed else 0.0
        base = 0.0 if self.bed else low[2]

        def of(s):
            v = V - w * (L - s)
            tension = np.hypot(H, v)
            up = np.hypot(H, v) - np.hypot(H, V - w * (L - on_bed))
            rise = up / w + (v * v - (V - w * (L - on_bed)) ** 2) / (2 * EA * w)
            return np.array([tension**2 / (2 * EA) + w * (base + rise)])

        kinks = [L - V / w] if on_bed < L - V / w < L else None
        free = quad_vec(of, on_bed, L, epsrel=1e-12, points=kinks)[0][0]
        return free + H * H * on_bed / (2 * EA)

    def act(self, now):
        """At an instant."""
        first, second = (now.frame(end)[0] for end in self.ends)
        on, on_bed, self.energy = self.forces(first, second, -now.system.gravity[2])
        power = sum(now.push(end, force) for end, force in zip(self.ends, on))
        anchor, tension = (np.linalg.norm(force) for force in on)
        self.now = {"tension": tension, "anchor_tension": anchor, "grounded_length": on_bed, "force": on[1]}
        self.now |= {"power": power}


class Member:
    """Drag on a round member of one body."""

    kind = "member"
    energy = 0.0

    def __init__(self, given, name, force, sea):
        spec, current = force["member"], sea.get("current") or {}
        self.name, self.ends = name, force["between"]
        self.diameter = spec["diameter"]
        self.across = given(spec.get("drag", 1.0), name, "drag")
        self.along = given(spec.get("axial_drag", 0.0), name, "axial_drag")
        self.sections = int(spec.get("sections", 4))
        self.density = sea.get("density", 1025.0)
        velocity = np.array(current.get("velocity", np.zeros(3)), float)
        self.velocity = given(velocity, "sea", "current") if current else velocity
        self.exponent, self.depth = current.get("exponent", 0.0), sea.get("depth") or 1.0

    def water(self, z):
        """Velocity of the water (m/s)."""
        return self.velocity * max(1 + min(z, 0.0) / self.depth, 0.0) ** self.exponent

    def drag(self, first, second, r, v, w):
        """(force, moment about r, power) of the water. r, v, w : of the body's frame at the first end."""
        way = second - first
        length = np.linalg.norm(way)
        axis = way / length
        total = np.zeros(7)
        nodes = (np.polynomial.legendre.leggauss(2)[0] + 1) / 2
        ends = [first + k / self.sections * way for k in range(self.sections + 1)]
        places = [(end, 1.0, False) for end in (first, second) if end[2] <= 0]

        # two points on what of each section is under water
        for low, high in itertools.pairwise(ends):
            wet = [0.0, 1.0]
            if low[2] * high[2] < 0:
                wet[int(low[2] < 0)] = low[2] / (low[2] - high[2])
            elif max(low[2], high[2]) > 0:
                continue
            share = (wet[1] - wet[0]) * length / (2 * self.sections)
            places += [(low + (wet[0] + (wet[1] - wet[0]) * x) * (high - low), share, True) for x in nodes]

        for place, size, lateral in places:
            speed = v + cross(w, place - r)
            u = self.water(place[2]) - speed
            part = u - (u @ axis) * axis if lateral else (u @ axis) * axis
            area = self.diameter * self.across if lateral else np.pi * self.diameter**2 / 4 * self.along
            f = self.density / 2 * area * size * np.linalg.norm(part) * part
            total += [*f, *cross(place - r, f), f @ speed]

        return total[:3], total[3:6], total[6]

    def act(self, now):
        """At an instant."""
        (r, _, v, w), (other, _, _, _) = (now.frame(end) for end in self.ends)
        force, moment, power = self.drag(r, other, r, v, w)
        now.push(self.ends[0], force, moment)
        now.dissipated -= power
        self.now = {"force": force, "power": power}
