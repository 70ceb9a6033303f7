"""What can be told of an instant, by the variables' names."""

import numpy as np
from scipy.spatial.transform import Rotation

from .acting import ACTING
from .motion import turning_axes, zyx
from .reading import cross, dotted

# by how much what is told may change along what the equations leave open, as a part of its size
OPEN = 1e-6

# cosine of a pitch at which yaw and roll are hardly told apart
UPRIGHT = 1e-5


def tell(system, now):
    """Outputs by name; those that the equations leave open, as reactions of redundant joints,
    and those without a value, as of a bushing's twist at a swing by 180 degrees, are left out."""
    told = {name: value for name, value in _told(system, now, now.x).items() if np.isfinite(value).all()}

    if now.undecided is not None:
        other = _told(system, now, now.undecided)
        told = {name: value for name, value in told.items() if _same(value, other[name])}

    return told | {"constraint residuals": now.residuals, "constraint rates": now.rates}


def _same(value, other):
    """Whether the other solution tells the same."""
    return np.abs(np.subtract(value, other)).max(initial=0.0) <= OPEN * (1.0 + np.abs(value).max(initial=0.0))


def _told(system, now, x):
    """All outputs for accelerations and multipliers x."""
    told = {}
    n = len(now.bias)
    acceleration, multipliers = x[:n], x[n:]
    seen = Motions(system, now, acceleration)

    for body, table in system.data.get("body", {}).items():
        for path, spec in (
            ((body,), table),
            *(((body, key), spec) for key, spec in table.get("marker", {}).items()),
        ):
            _tell_marker(told, seen, now, path, spec)

    for name, joint in system.joints.items():
        _tell_joint(told, system, now, seen, joint, acceleration, multipliers)

    for name in system.couplings:
        multiplier = multipliers[now.rows_of["coupling", name][0]]
        efforts = multiplier * system.couplings[name].factors
        _put(told, dotted(name), {"efforts": efforts}, system.data["coupling"][name])

    for e in system.elements.values():
        _tell_element(told, e, system.data["force"][e.name])

    for name, measure in system.data.get("measure", {}).items():
        _tell_measure(told, seen, now, name, measure)

    _tell_scene(told, system, now, acceleration, multipliers)
    return told


class Motions:
    """Frames with their accelerations, and one seen from another."""

    def __init__(self, system, now, acceleration):
        self.system, self.now = system, now
        self.acceleration = {owner: acceleration[place] for owner, place in system.place.items()}
        self.acceleration["inertial"] = np.zeros(6)

    def of(self, end):
        """(r, A, v, w, a, alpha) of a frame, inertial axes."""
        r, A, v, w = self.now.frame(end)
        owner, position, _ = self.system.end(end)
        a, alpha = np.split(self.acceleration[owner], 2)

        if owner != "inertial":
            arm = self.now.motions[owner][1] @ position
            a = a + cross(alpha, arm) + cross(w, cross(w, arm))

        return r, A, v, w, a, alpha

    def relative(self, first, second):
        """The same of the second frame seen from the first, in the first one's axes."""
        (r1, A1, v1, w1, a1, alpha1), (r2, A2, v2, w2, a2, alpha2) = self.of(first), self.of(second)
        d = r2 - r1
        v = v2 - v1 - cross(w1, d)
        a = a2 - a1 - cross(alpha1, d) - cross(w1, cross(w1, d)) - 2 * cross(w1, v)
        alpha = alpha2 - alpha1 - cross(w1, w2)
        return A1.T @ d, A1.T @ A2, A1.T @ v, A1.T @ (w2 - w1), A1.T @ a, A1.T @ alpha


def zyx_rate(A, w):
    """Their rates: w = yaw' z + pitch' y after the yaw + roll' x of the frame."""
    yaw = np.arctan2(A[1, 0], A[0, 0])
    return np.linalg.solve(np.column_stack([[0, 0, 1], [-np.sin(yaw), np.cos(yaw), 0], A[:, 0]]), w)


def euler_parameters(A, hint):
    """Scalar last, of the hint's sign."""
    E = Rotation.from_matrix(A).as_quat()
    return -E if (E[3] < 0 if hint is None else E @ hint < 0) else E


def _put(told, name, values, table):
    """Several outputs of one name; of two parts of that name the one whose table asks for the output tells
    it."""
    for output, value in values.items():
        key = f"{name}.{output}"

        if key not in told or output in table.get("output", ()):
            told[key] = value


def _pose(motion, now, *names):
    """What a pose and its motion are told by."""
    hint, near = now.hints(*names, "euler_parameters"), now.hints(*names, "zyx")
    r, A, v, w, a, alpha = motion
    values = {"position": r, "euler_parameters": euler_parameters(A, hint), "velocity": v, "omega": w}
    values |= {"acceleration": a, "alpha": alpha}

    # upright yaw and roll are one
    if np.hypot(A[0, 0], A[1, 0]) > UPRIGHT:
        values |= {"zyx": zyx(A, near), "zyx_rate": zyx_rate(A, w)}

    return values


def _tell_marker(told, seen, now, path, table):
    motion = seen.of(".".join(path))
    own = {"velocity": motion[2], "acceleration": motion[4], "omega": motion[3], "alpha": motion[5]}
    own = {f"{key}_body": motion[1].T @ value for key, value in own.items()}
    _put(told, dotted(*path), _pose(motion, now, *path) | own, table)


def _tell_measure(told, seen, now, name, table):
    r, A, v, *_ = motion = seen.relative(*table["between"])
    values = _pose(motion, now, name)
    del values["alpha"]
    distance = np.linalg.norm(r)
    values |= {"distance": distance, "distance_rate": r @ v / distance if distance else 0.0}
    values["angle"] = np.arctan2(np.hypot(*A[:2, 2]), A[2, 2])
    _put(told, dotted(name), values, table)


def _tell_joint(told, system, now, seen, joint, acceleration, multipliers):
    values, groups = {}, {}

    if joint.kind in ("spherical", "free", "prescribed"):
        values = _pose(seen.relative(*joint.ends), now, joint.name)

    for k, (position, rate, _) in enumerate(joint.coordinates):
        groups.setdefault(position, []).append(now.q[joint.name][k])
        groups.setdefault(rate, []).append(now.rate[joint.name][k])

    if joint.name in system.contacts:
        groups |= {"s": now.s[joint.name], "s_rate": now.s_rate[joint.name]}
        values |= dict(
            zip(("tangent", "binormal", "normal"), system.contacts[joint.name].axes(now.s[joint.name]))
        )

    if joint.kind == "prescribed":
        bears = multipliers[now.rows_of[joint.name]]
        values["driver_force"] = bears[:3]
        values["driver_torque"] = turning_axes(now.turned[joint.name]).T @ bears[3:]
    elif joint.driver and joint.name in system.contacts:
        values["effort"] = multipliers[now.rows_of["driver", joint.name][0]]
        values["driver_power"] = values["effort"] * now.s_rate[joint.name][0]

    values |= {key: group[0] if len(group) == 1 else np.array(group) for key, group in groups.items()}
    along = 0.0

    if joint.parts:
        _, _, bias, J = now.values["coordinates", joint.name]
        efforts = dict(now.efforts[joint.name])

        if joint.driver:
            along = values["effort"] = efforts["driver"] = multipliers[now.rows_of["driver", joint.name][0]]

        values["acceleration"] = J[0] @ acceleration + bias[0]
        values["power"] = sum(efforts.values()) * now.rate[joint.name][0]
        values |= {f"{part}_effort": effort for part, effort in efforts.items()}
        along += _coupled(system, now, joint.name, multipliers)

        if joint.rotor:
            along -= now.rotor_effort(joint.name, acceleration)

    values |= _reaction(system, now, joint, along, multipliers)
    _put(told, dotted(joint.name), values, system.data["joint"][joint.name])


def _reaction(system, now, joint, along, multipliers):
    """The wrench of all that is in the joint on its second marker, in the first one's axes and in its own.

    along : effort of driver and couplings along its coordinate, less what a rotor takes.
    """
    other, owner = (system.end(end)[0] for end in joint.ends)

    if owner in (other, "inertial") or joint.kind == "free":
        return {}

    rows = now.rows_of.get(joint.name, [])
    wrench = now.C[rows].T @ multipliers[rows] + now.inside[joint.name]

    if joint.parts:
        wrench = wrench + now.values["coordinates", joint.name][3][0] * along

    force, moment = np.split(wrench[system.place[owner]], 2)
    (_, A1, _, _), (r2, A2, _, _) = (now.frame(end) for end in joint.ends)
    moment = moment - cross(r2 - now.motions[owner][0], force)
    return {
        "reaction_force": A1.T @ force, "reaction_moment": A1.T @ moment,
        "reaction_force_body": A2.T @ force, "reaction_moment_body": A2.T @ moment,
    }  # fmt: skip


def _coupled(system, now, joint, multipliers):
    """Effort of couplings along a joint's coordinate."""
    effort = 0.0

    for name, coupling in system.couplings.items():
        multiplier = multipliers[now.rows_of["coupling", name][0]]
        effort += sum(
            multiplier * factor for other, factor in zip(coupling.between, coupling.factors) if other == joint
        )

    return effort


def _tell_element(told, e, table):
    if e.kind == "load":
        values = {"power": e.now}
    elif e.kind in ACTING:
        values = e.now
    elif e.kind == "hydrodynamics":
        values = e.told
    elif e.kind == "torsion":
        angle, rate, (spring, damper) = e.now
        values = {"angle": angle, "rate": rate, "spring_moment": spring, "damper_moment": damper}
        values |= {"moment": spring + damper, "power": (spring + damper) * rate}
    elif e.kind == "spring_damper":
        length, rate, parts = e.now
        values = dict(zip(("spring_force", "damper_force", "input_force"), parts))
        values |= {
            "length": length,
            "rate": rate,
            "tension": sum(parts),
            "force": sum(parts),
            "power": -sum(parts) * rate,
        }
        del values["force" if e.has_input else "input_force"]
    else:
        force, moment, moved, rate = e.now
        values = {"force": force, "moment": moment, "displacement": moved[:3], "rotation": moved[3:]}
        values["power"] = force @ rate[:3] + moment @ rate[3:]

    _put(told, dotted(e.name), values, table)


def _tell_scene(told, system, now, acceleration, multipliers):
    """Energies, powers, momenta, the ground's reaction."""
    kinetic = gravity = spring = 0.0
    linear, angular, centre, total = np.zeros(3), np.zeros(3), np.zeros(3), 0.0

    for name, (mass, com, inertia) in system.mass.items():
        r, A, v, w = now.motions[name][:4]
        place, speed = r + A @ com, v + cross(w, A @ com)
        spin = A @ inertia @ A.T @ w
        kinetic += (mass * speed @ speed + w @ spin) / 2
        gravity -= mass * system.gravity @ place + (
            system.mu * mass / np.linalg.norm(place) if system.mu else 0.0
        )

        if system.gradient and mass > 0:
            e, length = place / np.linalg.norm(place), np.linalg.norm(place)
            own = A @ inertia @ A.T
            gravity -= system.mu / (2 * length**3) * (np.trace(own) - 3 * e @ own @ e)

        linear = linear + mass * speed
        angular = angular + cross(place, mass * speed) + spin
        centre, total = centre + mass * place, total + mass

    for e in system.elements.values():
        if e.kind in ("spring_damper", "torsion"):
            spring += e.spring.energy(e.now[0])
        elif e.kind in ACTING:
            spring += e.energy
        elif e.kind != "load":
            spring += e.energy(e.now[2])

            if e.adds:
                A, _ = e.mass_now
                momentum = A @ e.now[3]
                kinetic += e.now[3] @ momentum / 2
                axes, place = now.frame(e.ends[0])[1], now.frame(e.ends[1])[0]
                p, L = axes @ momentum[:3], axes @ momentum[3:]
                linear, angular = linear + p, angular + cross(place, p) + L

    for name, joint in system.joints.items():
        if joint.parts:
            spring += joint.parts.energy(now.q[name][0])

        if joint.rotor:
            (J, n, along, _), rate = now.rotor(name), now.rate[name][0]
            kinetic += n * n * J * rate**2 / 2 + n * J * rate * along @ now.frame(joint.ends[0])[3]
            angular = angular + n * J * rate * along

    ground = _on_ground(now, acceleration, multipliers)
    _, A, v, w, *_ = now.motions["ground"]
    told["ground.reaction_force"], told["ground.reaction_moment"] = A.T @ ground[:3], A.T @ ground[3:]
    driven = -ground @ np.concatenate([v, w])

    for name, joint in system.joints.items():
        if joint.kind == "prescribed":
            driven += multipliers[now.rows_of[name]] @ now.values["slip", name][0]
        elif joint.driver:
            rate = now.s_rate[name] if name in system.contacts else now.rate[name]
            driven += multipliers[now.rows_of["driver", name][0]] * rate[0]

    told |= {"kinetic_energy": kinetic, "gravity_energy": gravity, "spring_energy": spring}
    told |= {"potential_energy": gravity + spring, "total_energy": kinetic + gravity + spring}
    told |= {"linear_momentum": linear, "angular_momentum": angular}
    told |= {"center_of_mass": centre / total} if total else {}
    told |= {"input_power": now.input_power, "load_power": now.load_power, "dissipated_power": now.dissipated}
    told["driver_power"] = driven


def _on_ground(now, acceleration, multipliers):
    """Force and moment about its origin on the ground: joints, forces, added mass."""
    on = now.pull + now.C.T @ multipliers - now.M @ acceleration - now.bias
    return on[:6]
