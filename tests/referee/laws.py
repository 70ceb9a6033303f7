"""Laws that any run must keep, whatever way it was made: energy, momentum, constraints, orientations,
finite values.

Integrals over time are by Simpson's rule over the communication points of runs made for it (PANELS equal
steps in each interval of the plan); what half the points give tells how good they are, and what does not
balance must not do so with more points either.
"""

import numpy as np

from mbdfmi.scene import fmi_name

from .compare import LOOSE, SAFETY, groups
from .findings import Finding
from .ways import ARRIVING, TIGHT

PANELS = 16
FINER = 8  # times as many
STAYS = 0.6  # part of what does not balance that more points leave where a law is broken

# a communication step ends after as many evaluations as it may cost, and those of the inner step under way
ROOM = 1.5
AT_LEAST = 20000

# m or rad, and their rates: what projection may leave of a gap, relative to the largest position and speed
GAP = 1e-7
UNIT = 1e-12

# coordinates of joints -> their speeds; how far a coordinate and the integral of its speed may part, of the largest value
SPEEDS = {
    "angle": ("speed", "angular_speed"),
    "position": ("speed",),
    "angles": ("speeds",),
    "s": ("s_rate",),
}
COURSE = 1e-7

# what acts on bodies from outside, and not by the ground
EXTERNAL = {"load", "hydrostatics", "catenary", "member", "hydrodynamics", "rotor"}


def always(run, data):
    """Findings in a run by itself."""
    found = []
    name = str(run.way)

    if run.crashed:
        found.append(Finding("crash", name, text=run.crashed.strip()))

    found += [Finding("odd", name, text=text) for text in run.odd]

    if run.refused is not None or run.stopped is not None:
        found += told_why(run)

    if run.most > ROOM * run.way.evaluations + AT_LEAST:
        text = "evaluations in one communication step"
        found.append(Finding("work", name, found=run.most, wanted=run.way.evaluations, text=text))

    if not run.values:
        return found

    values = np.array(run.values)

    if not np.isfinite(values).all():
        k, c = np.argwhere(~np.isfinite(values))[0]
        found.append(
            Finding(
                "not finite", name, run.names[c], run.times[k], values[k, c], text="and the status was OK"
            )
        )
        return found

    for group, columns in groups(run.names).items():
        if group.endswith("euler_parameters"):
            off = np.abs(np.linalg.norm(values[:, columns], axis=1) - 1.0)
            k = int(off.argmax())

            if off[k] > UNIT:
                found.append(
                    Finding("orientation", name, group, run.times[k], 1.0 + off[k], 1.0, UNIT, "its length")
                )

    return found + gaps(run, values, data)


def told_why(run):
    """A run that ended early tells why in words, and where or when."""
    text = run.refused or run.stopped or ""
    bad = not text.strip() or "failure " in text or " ? " in text or "Traceback" in text or "internal" in text
    return [Finding("not told", str(run.way), text=f"it stopped with {text!r}")] if bad else []


def gaps(run, values, data):
    """What constraints are open, beyond what the start was told to leave."""
    solver = data.get("solver", {})
    allowed = max(GAP, 10.0 * solver.get("closing_tolerance", 1e-9))

    # of many notices only the first are told
    if any("does not quite close" in text or "more of this kind" in text for text in run.notices):
        return []

    found = []
    columns = groups(run.names)
    reach = {"constraint_gap": "position", "constraint_rate": "velocity"}

    for group, ending in reach.items():
        if group not in columns:
            continue

        column = values[:, columns[group][0]]
        size = max([1.0, *(np.abs(values[:, c]).max() for g, c in columns.items() if g.endswith(ending))])
        k = int(column.argmax())

        if column[k] > allowed * size:
            found.append(
                Finding("constraint", str(run.way), group, run.times[k], column[k], 0.0, allowed * size)
            )

    return found


class Integrals:
    """Simpson's integrals of a run over the intervals of the plan, each in so many steps. jumps : s,
    where speeds jump; edges : as `edges` gives them."""

    def __init__(self, run, panels=PANELS, jumps=(), edges=()):
        self.jumps = np.array(sorted(jumps))
        self.edges = edges
        self.run = run
        self.values = np.array(run.values)
        self.columns = groups(run.names)
        phases = np.array(run.phases)
        self.ends = np.flatnonzero(phases == ARRIVING)[1:]
        self.begins = self.ends - panels

    def of(self, rows):
        """(integrals (n, …), how good they are (n, …)) of values at all rows."""
        whole, error = [], []

        for a, b in zip(self.begins, self.ends):
            H = self.run.times[b] - self.run.times[a]
            fine, coarse = (_simpson(rows[a : b + 1 : stride], H) for stride in (1, 2))
            whole.append(fine)
            error.append(np.abs(fine - coarse))

        return np.array(whole), np.array(error)

    def change(self, name):
        """Change (n, k) of outputs over each interval."""
        values = self.values[:, self.columns[name]]
        return values[self.ends] - values[self.begins]

    def get(self, name):
        return self.values[:, self.columns[name]]

    def is_broken(self, k):
        """Whether speeds jump in interval k, at times or where a frame passes the end of its curve, or the
        rotation that a linear force or a bushing counts begins anew: energy then jumps."""
        a, b = self.run.times[self.begins[k]], self.run.times[self.ends[k]]

        if np.any((self.jumps >= a - 1e-9) & (self.jumps <= b + 1e-9)):
            return True

        rows = slice(self.begins[k], self.ends[k] + 1)

        for name, component, at in self.edges:
            s = self.values[rows, self.columns[name][component]]

            if s.min() <= at <= s.max():
                return True

        turns = [
            np.diff(self.values[rows][:, c], axis=0)
            for g, c in self.columns.items()
            if g.endswith(".rotation")
        ]
        return any(np.abs(turn).max() > 2.0 for turn in turns)


def _simpson(values, H):
    n = len(values) - 1
    weights = np.array([1.0, *[4.0, 2.0] * (n // 2 - 1), 4.0, 1.0]) * H / (3 * n)
    return np.tensordot(weights, values, 1)


def energy(integrals, reference, count):
    """The rate of the total energy is the power of inputs, loads and drivers less what is dissipated."""
    i = integrals
    power = i.get("input_power") + i.get("load_power") + i.get("driver_power") - i.get("dissipated_power")
    work, error = i.of(power)
    parts = [i.get(name) for name in ("kinetic_energy", "gravity_energy", "spring_energy")]
    size = sum(np.abs(part).max() for part in parts) + np.abs(work).max()
    return _balance("energy", "total_energy", i, work, error, size, reference, count)


def courses(integrals, count):
    """Coordinates of joints change by the integrals of their speeds, over full turns too."""
    i, found = integrals, []

    for name, columns in i.columns.items():
        owner, _, quantity = name.rpartition(".")
        rates = [f"{owner}.{rate}" for rate in SPEEDS.get(quantity, ()) if f"{owner}.{rate}" in i.columns]

        if len(rates) != 1 or len(i.columns[rates[0]]) != len(columns):
            continue

        change, (way, error) = i.change(name), i.of(i.get(rates[0]))
        size = 1.0 + np.abs(i.get(name)).max() + np.abs(way).max()

        for k in range(len(change)):
            allowed = 2.0 * error[k].max() + COURSE * size
            off = np.abs(change[k] - way[k])
            c = int(off.argmax())

            if allowed <= LOOSE * size and not i.is_broken(k):
                count.made += 1

                if off[c] > allowed:
                    text = "change over the interval that ends there, and the integral of its speed"
                    at = i.run.times[i.ends[k]]
                    found.append(
                        Finding("course", str(i.run.way), name, at, change[k][c], way[k][c], allowed, text)
                    )
                    break

    return found


def momentum(integrals, reference, count, mass, gravity):
    """What changes the momenta is the weight and what the ground, at rest, takes.

    mass (kg), gravity (m/s2, (3,)) : in each interval.
    """
    i = integrals
    weight = np.zeros((len(i.values), 3))

    for k, (a, b) in enumerate(zip(i.begins, i.ends)):
        weight[a : b + 1] = mass[k] * gravity[k]

    force = weight - i.get("ground.reaction_force")
    moment = np.cross(i.get("center_of_mass"), weight) - i.get("ground.reaction_moment")
    found = []

    for name, rate, of in (
        ("linear_momentum", force, weight),
        ("angular_momentum", moment, i.get("ground.reaction_moment")),
    ):
        change, error = i.of(rate)
        size = np.abs(i.get(name)).max() + (np.abs(change) + np.abs(of).max() * i.run.times[-1]).max()
        found += _balance("momentum", name, i, change, error, size, reference, count)

    return found


def _balance(verdict, name, integrals, wanted, error, size, reference, count):
    i, found = integrals, []
    change = i.change(name)
    growth = reference.growth[name] if name in reference.growth else np.zeros(len(reference.times))

    for k in range(len(change)):
        at = np.searchsorted(reference.times, i.run.times[i.ends[k]] + 1e-9, "right") - 1
        if i.is_broken(k):
            count.add("intervals over which energy jumps")
            continue

        allowed = 2.0 * error[k].max() + SAFETY * 2 * TIGHT * growth[at] + 1e-9 * size
        count.made += 1

        if not allowed <= LOOSE * size:
            count.loose += 1
            continue

        off = np.abs(change[k] - wanted[k])
        c = int(off.argmax())

        if off[c] > allowed:
            at = i.run.times[i.ends[k]]
            text = "change over the interval that ends there, and what acts"
            found.append(
                Finding(verdict, str(i.run.way), name, at, change[k][c], wanted[k][c], allowed, text)
            )
            break

    return found


def persists(finding, finer):
    """Whether what does not balance is still there with more points."""
    if finding.variable != finer.variable or abs(finding.time - finer.time) > 1e-9 * max(1.0, finding.time):
        return False

    return abs(finer.found - finer.wanted) > STAYS * abs(finding.found - finding.wanted)


def bears_all(data):
    """Whether all that acts from outside is weight and the ground's reaction, the ground at rest."""
    if data.get("central_gravity") or data.get("ground", {}).get("motion"):
        return False

    for body in data["body"].values():
        markers = body.get("marker", {}).values()

        if body.get("input") or any(marker.get("input") for marker in markers):
            return False

    forces = data.get("force", {}).values()
    return not any(
        EXTERNAL.intersection(force) or "added_mass" in force.get("linear", {}) for force in forces
    )


def mass_and_gravity(scene, plan):
    """(kg (n,), m/s2 (n, 3)) in each interval of the plan, as its settings change them."""
    masses = {f"{fmi_name(name)}.mass": body.mass_properties()[0] for name, body in scene.body.items()}
    now = masses | {f"gravity[{k + 1}]": g for k, g in enumerate(scene.gravity)}
    found = []

    for k in range(len(plan.points) - 1):
        now |= {name: value for name, value in plan.settings.get(k, {}).items() if name in now}
        found.append((sum(now[name] for name in masses), [now[f"gravity[{j}]"] for j in (1, 2, 3)]))

    return np.array([mass for mass, _ in found]), np.array([gravity for _, gravity in found])


def bed_moves(data):
    """Whether a line may lie on a bed that rises and falls, whose work nobody counts (a notice says so)."""
    for force in data.get("force", {}).values():
        if "catenary" in force and (bed := force["catenary"].get("bed")) is not False:
            owner = force["between"][0].partition(".")[0]
            if data.get("ground", {}).get("motion") if owner == "ground" else bed and owner != "inertial":
                return True

    return False


def drivers(data):
    """The drivers of joints, of prescribed ones each of theirs."""
    found = [(joint, joint["driver"]) for joint in data.get("joint", {}).values() if joint.get("driver")]
    return [
        one for joint, driver in found for one in (driver.values() if "prescribed" in joint else [driver])
    ]


def jumps(data):
    """s, when tables of positions may make speeds jump, which no integral sees:
    everywhere where they are straight, and at their ends but where smooth ones stand still there.
    """
    tables = [driver.get("table") for driver in drivers(data)]
    tables.append(data.get("ground", {}).get("motion", {}).get("table"))
    found = set()

    for table in filter(None, tables):
        time, how = table["time"], table.get("interpolation", "smooth")
        rows = [value for key, value in table.items() if key not in ("time", "interpolation")]
        # a spline leaves two equal points with a slope
        ends = [
            time[k]
            for k, next_one in ((0, 1), (-1, -2))
            if any(row[k] != row[next_one] or how != "smooth" for row in rows)
        ]
        found |= set(time if how == "linear" else ends)

    return found


def edges(scene):
    """(name of the parameters, which, value) where frames that are held to curves and surfaces through points stop
    turning at once, for these go on straight there."""
    found = []

    for name, joint in scene.joint.items():
        if joint.kind == "frame_on_curve":
            ways = [scene.marker(joint.between[0]).curve]
        elif joint.kind == "frame_on_surface":
            surface = scene.marker(joint.between[0]).surface
            ways = [surface.profile] if surface.kind == "prism" else []
            found += _both(name, [surface.s1, surface.s2] if surface.kind == "table" else [])
        else:
            continue

        found += _both(name, [way.s for way in ways if hasattr(way, "points") and not way.closed])

    return found


def _both(name, ways):
    """The first and the last of the values of each parameter."""
    return [(f"{fmi_name(name)}.s", k, s[end]) for k, s in enumerate(ways) for end in (0, -1)]
