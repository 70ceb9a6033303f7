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
        spec, self.density = force["catenary"], sea.get("density", 1025.0)
        self.name, self.ends = name, force["between"]
        sections, self.parts = spec.get("sections"), []

        # length, mass and stiffness of each, the mass over it
        for k, section in enumerate(sections or [spec]):
            index = f"[{k + 1}]" if sections else ""
            values = (section["length"], self.wet(section), section["stiffness"])
            part = [
                given(value, name, f"{key}{index}")
                for key, value in zip(("length", "mass", "stiffness"), values)
            ]
            clump = section.get("clump", {})
            last = not sections or k == len(sections) - 1
            over = clump.get("mass", 0.0) - self.density * clump.get("volume", 0.0)
            self.parts.append((*part, 0.0 if last else given(over, name, f"clump[{k + 1}]")))

        self.friction = given(spec["friction"], name, "friction") if spec.get("friction") else 0.0
        self.length = sum(L for L, *_ in self.parts)
        self.bed = spec.get("bed")

        if self.bed is None:
            (owner, position, _), depth = anchor, sea.get("depth")
            self.bed = owner in ("ground", "inertial") and (not depth or position[2] < -0.99 * depth)

    def wet(self, section):
        """kg/m in water."""
        return section["mass"] - self.density * np.pi * section.get("diameter", 0.0) ** 2 / 4

    def walk(self, g, H, V):
        """From the second end: (m, N/m, N, H, v above, v below) of each part that hangs, (m, N, N, N) of each that lies with its
        pulls; then what is left at the first end."""
        h, v, parts = H, V, []

        for L, mass, EA, over in reversed(self.parts):
            w, v = mass * g, v - over * g

            # borne by the bed
            if self.bed and v < 0.0:
                h, v = max(h + self.friction * v, 0.0), 0.0

            up = min(L, v / w) if self.bed else L
            parts.append(("hangs", up, w, EA, h, v, v - w * up))
            v = v - w * up
            left = max(h - self.friction * w * (L - up), 0.0)
            parts.append(("lies", L - up, w, EA, h, left))
            h = left

        return parts, h, v

    def reach(self, g, H, V):
        """(x, z) of the ends at a pull."""
        x = z = 0.0

        for kind, L, w, EA, h, *ends in self.walk(g, H, V)[0]:
            if kind == "lies":
                grips = self.friction * w
                x += L + ((h * h - ends[0] ** 2) / (2 * EA * grips) if grips > 0.0 else h * L / EA)
                continue

            v, low = ends
            if h > 0.0:
                x += h / w * (np.arcsinh(v / h) - np.arcsinh(low / h)) + h * L / EA
            z += (np.hypot(h, v) - np.hypot(h, low)) / w + (v * v - low * low) / (2 * EA * w)

        return x, z

    def pull(self, g, x, z):
        """(H, V): for each H the V that rises to z, and the H that then spans x."""
        size = sum(L * abs(mass) + abs(over) for L, mass, _, over in self.parts) * g
        give = sum(L / EA for L, _, EA, _ in self.parts)

        # more than either end ever pulls
        most = 10 * (size + self.length / give * (1 + (x + abs(z)) / self.length))
        least = 0.0 if self.bed else -most
        low = 1e-9 * size if not self.bed else 0.0

        def lift(H):
            if self.bed and z <= 0.0:
                return 0.0
            return brentq(lambda V: self.reach(g, H, V)[1] - z, least, most, xtol=1e-13, rtol=1e-15)

        span = lambda H: self.reach(g, H, lift(H))[0] - x

        if span(low) >= 0.0:
            return 0.0, lift(low)

        H = brentq(span, low, most, xtol=1e-13, rtol=1e-15)
        return H, lift(H)

    def forces(self, first, second, g):
        """{marker's side: force} on the first and second end (N), length on the bed (m), energy (J). first, second : m."""
        way = second - first
        x = np.hypot(*way[:2])
        H, V = self.pull(g, x, way[2])
        parts, h, v = self.walk(g, H, V)
        along = way * [1, 1, 0] / x if x > 0 else np.zeros(3)
        on = (h * along + [0, 0, v], -H * along - [0, 0, V])
        lying = sum(part[1] for part in parts if part[0] == "lies")
        return on, lying, self.stored(parts, 0.0 if self.bed else first[2], g)

    def stored(self, parts, base, g):
        """J: strain along the line, and weight by height over the bed, or over 0 without one. parts : from the second end."""
        total, z, over = 0.0, base, [mass for *_, mass in self.parts]

        for k, (kind, L, w, EA, h, *ends) in enumerate(reversed(parts)):
            if kind == "lies":
                pulls = lambda s, h=h, w=w, left=ends[0]: np.maximum(h - self.friction * w * s, left)
                edge = [h / (self.friction * w)] if self.friction * w * L > h > 0.0 else None
                total += quad_vec(
                    lambda s, EA=EA: pulls(s) ** 2 / (2 * EA), 0.0, L, epsrel=1e-12, points=edge
                )[0]
                continue

            v, low = ends

            def of(s, w=w, EA=EA, h=h, low=low, z=z):
                now = low + w * s
                rise = (np.hypot(h, now) - np.hypot(h, low)) / w + (now * now - low * low) / (2 * EA * w)
                return (h * h + now * now) / (2 * EA) + w * (z + rise)

            kinks = [-low / w] if 0.0 < -low / w < L else None
            total += quad_vec(of, 0.0, L, epsrel=1e-12, points=kinks)[0]
            z += (np.hypot(h, v) - np.hypot(h, low)) / w + (v * v - low * low) / (2 * EA * w)
            total += over[k // 2] * g * z

        return total

    def lost(self, places, velocities, power, g):
        """W, to friction: what the power on the bodies does not explain of the energy's rate, by differences in time."""
        if not (self.bed and self.friction > 0.0):
            return 0.0

        h = 1e-4 * self.length / (1e-9 * self.length + max(np.linalg.norm(v) for v in velocities))
        at = lambda t: self.forces(*(r + t * v for r, v in zip(places, velocities)), g)[2]
        rate = (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h)
        return -power - rate

    def act(self, now):
        """At an instant."""
        frames = [now.frame(end) for end in self.ends]
        places, velocities, g = [f[0] for f in frames], [f[2] for f in frames], -now.system.gravity[2]
        on, on_bed, self.energy = self.forces(*places, g)
        power = sum(now.push(end, force) for end, force in zip(self.ends, on))
        now.dissipated += self.lost(places, velocities, power, g)
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
