"""Makes the reference digits of problems of our own: `python -m benchmarks.reference.derive [NAME ...]`.

Nothing of the kernels is used: Lagrange's equations in minimal coordinates, in extended precision (numpy's
longdouble, 64 bits of mantissa on x86), by extrapolation of the modified midpoint rule (Hairer, Norsett,
Wanner, Solving ODEs I, section II.9). Two runs of different order and step tell how many digits are right.
"""

import json
import sys
from pathlib import Path

import numpy as np

real = np.longdouble
G = real("9.81")
HERE = Path(__file__).parent


def extrapolated(f, x, H, order):
    """x (n,) after a step H of x' = f(x), by Aitken-Neville over `order` / 2 midpoint sums."""
    rows = []

    for k in range(1, order // 2 + 1):
        n = 2 * k
        h = H / n
        before, now = x, x + h * f(x)

        for _ in range(n - 1):
            before, now = now, before + 2 * h * f(now)

        row = [(before + now + h * f(now)) / 2]

        for j, last in enumerate(rows[-1] if rows else []):
            ratio = (real(n) / (2 * (k - j - 1))) ** 2
            row.append(row[j] + (row[j] - last) / (ratio - 1))

        rows.append(row)

    return rows[-1][-1]


def solution(f, x, times, H, order):
    """x at the times (n_t, n), by steps of at most H."""
    x, t, rows = np.array(x, real), real(0), []

    for until in times:
        n = int(np.ceil(float((until - t) / H) - 1e-9))

        for _ in range(n):
            x = extrapolated(f, x, (until - t) / n, order)

        t = until
        rows.append(x)

    return np.array(rows)


def solved(M, b):
    """M^-1 b by Gauss elimination, M symmetric positive: numpy's own has no longdouble."""
    M, b = M.copy(), b.copy()

    for k in range(len(b)):
        factors = M[k + 1 :, k] / M[k, k]
        M[k + 1 :] -= np.outer(factors, M[k])
        b[k + 1 :] -= factors * b[k]

    for k in reversed(range(len(b))):
        b[k] = (b[k] - M[k, k + 1 :] @ b[k + 1 :]) / M[k, k]

    return b


def digits_of(rows, others):
    """How many digits two solutions have in common, in the largest value of each quantity."""
    error = np.max(np.abs(rows - others) / np.abs(rows).max(axis=0))
    return round(float(-np.log10(error)), 1)


def chain(n, angle):
    """n uniform bars of 1 m and 1 kg, all at `angle` (rad) from the lowest position, at rest: f, x(0).

    x = absolute angles and their rates.
    """
    j, i = np.meshgrid(np.arange(1, n + 1), np.arange(1, n + 1))
    coupling = n - np.maximum(i, j) + real(1) / 2
    coupling[np.diag_indices(n)] = n - np.arange(1, n + 1) + real(1) / 3
    weight = G * (n - np.arange(1, n + 1) + real(1) / 2)
    off = coupling - np.diag(np.diag(coupling))

    def f(x):
        q, w = x[:n], x[n:]
        apart = q[:, None] - q
        force = -(off * np.sin(apart)) @ w**2 - weight * np.sin(q)
        return np.concatenate([w, solved(coupling * np.cos(apart), force)])

    return f, np.concatenate([np.full(n, angle, real), np.zeros(n, real)])


def chain_file(n, angle, times):
    """The problem as a dict."""
    f, x = chain(n, angle)
    rows = solution(f, x, times, real(1) / 100, 14)
    common = digits_of(rows, solution(f, x, times, real(1) / 160, 12))
    q, w = rows[:, :n], rows[:, n:]
    tip = [np.sin(q).sum(1), -np.cos(q).sum(1), (np.cos(q) * w).sum(1), (np.sin(q) * w).sum(1)]
    direction = np.array([np.sin(float(angle)), -np.cos(float(angle)), 0.0])
    half = (float(angle) - np.pi / 2) / 2
    bodies = [
        {
            "name": f"bar{k + 1}",
            "mass": 1.0,
            "inertia": [0.001, 1 / 12, 1 / 12, 0, 0, 0],
            "r0": ((k + 0.5) * direction).tolist(),
            "q0": [np.cos(half), 0, 0, np.sin(half)],
        }
        for k in range(n)
    ]
    joints = [
        revolute(f"bar{k}" if k else "ground", f"bar{k + 1}", (k * direction).tolist()) for k in range(n)
    ]
    return {
        "id": f"chain_bars_N{n}",
        "title": f"Chain of {n} uniform 1 m bars with revolute joints, released straight and aslant",
        "source": ["own definition (standard N-pendulum); reference by derive.py"],
        "how_obtained": "Lagrange's equations of the N-pendulum in absolute angles; extrapolation of order "
        f"14, H = 1/100 s, and of order 12, H = 1/160 s, in 64-bit mantissa, agree to {common} digits",
        "digits": int(common),
        "bodies": bodies,
        "joints": joints,
        "forces": [],
        "gravity": [0, -9.81, 0],
        "initial_conditions": f"straight, {np.degrees(float(angle)):.0f} degrees from the lowest position, "
        "at rest",
        "quantities": ["t", "tip_x", "tip_y", "tip_vx", "tip_vy", *(f"theta{k + 1}" for k in range(n))],
        "values": np.column_stack([times, *tip, q]).astype(float).tolist(),
    }


def revolute(i, j, point):
    """A joint about z."""
    return {"type": "revolute", "body_i": i, "body_j": j, "point": point, "axis": [0, 0, 1]}


# a four-bar whose crank, the shortest, can turn: crank, coupler, rocker and distance of the pivots, m
CRANK, COUPLER, ROCKER, GROUND = real(1), real("2.5"), real(2), real(2)


def four_bar_angles(q):
    """Angles of coupler and rocker from x, for that of the crank; the joint between them stands above."""
    x, y = GROUND - CRANK * np.cos(q), -CRANK * np.sin(q)
    d = np.hypot(x, y)
    phi = np.arctan2(y, x) + np.arccos((COUPLER**2 + d**2 - ROCKER**2) / (2 * COUPLER * d))
    far = CRANK * np.cos(q) + COUPLER * np.cos(phi) - GROUND, CRANK * np.sin(q) + COUPLER * np.sin(phi)
    return phi, np.arctan2(far[1], far[0])


def four_bar_rate(x):
    """x' of x = (crank's angle, its rate): M q'' + M' q'^2 / 2 + V' = 0, bars of 1 kg."""
    q, w = x
    phi, psi = four_bar_angles(q)
    p = CRANK * np.sin(psi - q) / (COUPLER * np.sin(phi - psi))
    r = CRANK * np.sin(q - phi) / (ROCKER * np.sin(psi - phi))
    pq = p * ((r - 1) / np.tan(psi - q) - (p - r) / np.tan(phi - psi))
    rq = r * ((1 - p) / np.tan(q - phi) - (r - p) / np.tan(psi - phi))
    cross = CRANK * COUPLER
    M = CRANK**2 / 3 + CRANK**2 + COUPLER**2 / 3 * p**2 + cross * p * np.cos(q - phi) + ROCKER**2 / 3 * r**2
    Mq = 2 * COUPLER**2 / 3 * p * pq + 2 * ROCKER**2 / 3 * r * rq
    Mq += cross * (pq * np.cos(q - phi) - p * (1 - p) * np.sin(q - phi))
    Vq = G * (CRANK * 3 / 2 * np.cos(q) + COUPLER / 2 * p * np.cos(phi) + ROCKER / 2 * r * np.cos(psi))
    return np.array([w, -(Mq * w**2 / 2 + Vq) / M])


def four_bar_file(start, times):
    """The problem as a dict; start : crank's angle, rad."""
    x = np.array([start, 0], real)
    rows = solution(four_bar_rate, x, times, real(1) / 100, 14)
    common = digits_of(rows, solution(four_bar_rate, x, times, real(1) / 160, 12))
    q = rows[:, 0]
    phi, psi = np.array([four_bar_angles(a) for a in q]).T
    coupler = [CRANK * np.cos(q) + COUPLER / 2 * np.cos(phi), CRANK * np.sin(q) + COUPLER / 2 * np.sin(phi)]
    phi0, psi0 = four_bar_angles(start)
    at = [0, 0], [np.cos(start) * CRANK, np.sin(start) * CRANK], [GROUND, 0]
    lengths, angles = (CRANK, COUPLER, ROCKER), (start, phi0, psi0)
    bodies, names = [], ("crank", "coupler", "rocker")

    for name, (px, py), length, angle in zip(names, at, lengths, angles):
        across = float(length**2 / 12)
        r = px + length / 2 * np.cos(angle), py + length / 2 * np.sin(angle)
        bodies.append(
            {
                "name": name,
                "mass": 1.0,
                "inertia": [0.001, across, across, 0, 0, 0],
                "r0": [float(r[0]), float(r[1]), 0],
                "q0": [float(np.cos(angle / 2)), 0, 0, float(np.sin(angle / 2))],
            }
        )

    far = [float(GROUND + ROCKER * np.cos(psi0)), float(ROCKER * np.sin(psi0)), 0]
    return {
        "id": "four_bar",
        "title": "Planar four-bar with a crank that could turn, swung by its weight; no singular position",
        "source": ["own definition; reference by derive.py"],
        "how_obtained": "the crank's angle alone, closure solved in closed form; extrapolation of order 14, "
        f"H = 1/100 s, and of order 12, H = 1/160 s, in 64-bit mantissa, agree to {common} digits",
        "digits": int(common),
        "bodies": bodies,
        "joints": [
            revolute("ground", "crank", [0, 0, 0]),
            revolute("crank", "coupler", [float(at[1][0]), float(at[1][1]), 0]),
            revolute("ground", "rocker", [float(GROUND), 0, 0]),
            revolute("coupler", "rocker", far),
        ],
        "forces": [],
        "gravity": [0, -9.81, 0],
        "initial_conditions": "crank at 60 degrees from x, at rest",
        "quantities": ["t", "crank", "crank_rate", "coupler", "rocker", "coupler_x", "coupler_y"],
        "values": np.column_stack([times, q, rows[:, 1], phi, psi, *coupler]).astype(float).tolist(),
    }


# a lift of uniform bars of 1 m and 1 kg, two a cell: mass (kg) of its shoe, stiffness (N/m) and length (m)
# of its spring
SHOE, PUSH, LOOSE = real("0.1"), real(10) ** 6, real("0.7")


def lift_rate(cells):
    """x' of x = (the bars' angle, its rate): M q'' + M' q'^2 / 2 + V' = 0."""
    squares = sum((real(k) + real(1) / 2) ** 2 for k in range(cells))

    def f(x):
        c, s = np.cos(x[0]), np.sin(x[0])
        M = cells * s**2 / 2 + 2 * squares * c**2 + real(cells) / 6 + SHOE * s**2
        half_slope = s * c * (real(cells) / 2 - 2 * squares + SHOE)
        pull = G * cells**2 * c - PUSH * (c - LOOSE) * s
        return np.array([x[1], -(half_slope * x[1] ** 2 + pull) / M])

    return f


def lift_file(cells, start, times):
    """The problem as a dict; start : the bars' angle, rad."""
    f, x = lift_rate(cells), np.array([start, 0], real)
    rows = solution(f, x, times, real(1) / 50, 14)
    common = digits_of(rows, solution(f, x, times, real(1) / 80, 12))
    c, s = float(np.cos(start)), float(np.sin(start))
    bodies = [{"name": "shoe", "mass": float(SHOE), "inertia": [0.001] * 3 + [0, 0, 0], "r0": [c, 0, 0]}]
    slide = {"type": "prismatic", "body_i": "ground", "body_j": "shoe", "point": [c, 0, 0], "axis": [1, 0, 0]}
    joints = [slide]

    for k in range(cells):
        for name, angle in ((f"up{k}", float(start)), (f"down{k}", float(np.pi - start))):
            turned = [float(np.cos(angle / 2)), 0, 0, float(np.sin(angle / 2))]
            middle = [c / 2, (k + 0.5) * s, 0]
            inertia = [0.001, 1 / 12, 1 / 12, 0, 0, 0]
            bodies.append({"name": name, "mass": 1.0, "inertia": inertia, "r0": middle, "q0": turned})

        left, right = (f"down{k - 1}", f"up{k - 1}") if k else ("ground", "shoe")
        joints.append(revolute(f"up{k}", f"down{k}", [c / 2, (k + 0.5) * s, 0]))
        joints.append(revolute(left, f"up{k}", [0, k * s, 0]))
        joints.append(revolute(right, f"down{k}", [c, k * s, 0]))

    ends = {"body_i": "ground", "point_i": [0, 0, 0], "body_j": "shoe", "point_j": [c, 0, 0]}
    spring = {"type": "spring_damper", "k": float(PUSH), "c": 0.0, "l0": float(LOOSE)}
    q, w = rows.T
    shoe = [np.cos(q), -np.sin(q) * w]
    return {
        "id": f"scissor_lift_{cells}",
        "title": f"Scissor lift of {cells} cells, {2 * cells - 1} loops in a row, on a spring",
        "source": ["own definition; reference by derive.py"],
        "how_obtained": "the bars' angle alone; extrapolation of order 14, H = 1/50 s, and of order 12, "
        f"H = 1/80 s, in 64-bit mantissa, agree to {common} digits",
        "digits": int(common),
        "bodies": bodies,
        "joints": joints,
        "forces": [spring | ends],
        "gravity": [0, -9.81, 0],
        "initial_conditions": f"bars at {float(start):g} rad from x, at rest",
        "quantities": ["t", "shoe_x", "shoe_vx", "top_y", "angle"],
        "values": np.column_stack([times, *shoe, (cells - real(1) / 2) * np.sin(q), q])
        .astype(float)
        .tolist(),
    }


# a net of balls of 1 kg, 1 m apart: stiffness N/m, damping N s/m and length (m) of its springs
STIFF, DAMPED, SHORT = 2000.0, 2.0, 0.9


def net_springs(n):
    """Pairs of balls, by rows of n, that springs join; and (ball, point of the ground (3,)) at two sides."""
    at = np.arange(n * n).reshape(n, n)
    pairs = [*zip(at[:-1].ravel(), at[1:].ravel()), *zip(at[:, :-1].ravel(), at[:, 1:].ravel())]
    ties = [(at[0, k], (-1.0, float(k), 0.0)) for k in range(n)]
    return pairs, ties + [(at[-1, k], (float(n), float(k), 0.0)) for k in range(n)]


def net_file(n, times):
    """The problem as a dict: balls in a plane, let go; forces through their centres do not turn them."""
    pairs, ties = net_springs(n)
    first = np.array([i for i, _ in pairs] + [i for i, _ in ties])
    second = np.array([j for _, j in pairs])
    points = np.array([point for _, point in ties], real)
    place = np.stack(np.meshgrid(np.arange(n), np.arange(n), [0], indexing="ij"), -1).reshape(-1, 3)

    def f(x):
        r, v = x.reshape(2, -1, 3)
        far = np.concatenate([r[second], points])
        span = far - r[first]
        rate = np.concatenate([v[second], np.zeros_like(points)]) - v[first]
        length = np.sqrt((span**2).sum(1, keepdims=True))
        along = span / length
        pull = along * (STIFF * (length - real("0.9")) + DAMPED * (along * rate).sum(1, keepdims=True))
        force = np.zeros_like(r)
        force[:, 2] = -G
        np.add.at(force, first, pull)
        np.subtract.at(force, second, pull[: len(second)])
        return np.concatenate([v.ravel(), force.ravel()])

    x = np.concatenate([place.ravel(), np.zeros(place.size)]).astype(real)
    rows = solution(f, x, times, real(1) / 250, 14)
    common = digits_of(rows, solution(f, x, times, real(1) / 400, 12))
    r, v = rows.reshape(len(times), 2, n * n, 3).transpose(1, 2, 3, 0)
    middle, corner = n * (n // 2) + n // 2, n - 1
    names = [f"ball{k + 1}" for k in range(n * n)]
    spring = {"type": "spring_damper", "k": STIFF, "c": DAMPED, "l0": SHORT}
    at = place.astype(float).tolist()
    forces = [
        spring | {"body_i": names[i], "point_i": at[i], "body_j": names[j], "point_j": at[j]}
        for i, j in pairs
    ]
    forces += [
        spring | {"body_i": names[i], "point_i": at[i], "body_j": "ground", "point_j": point}
        for i, point in ties
    ]
    kept = (r[middle, 2], v[middle, 2], r[corner, 1], r[corner, 2])
    return {
        "id": f"spring_net_{n}",
        "title": f"Net of {n} x {n} balls and {len(forces)} damped springs: {13 * n * n} states",
        "source": ["own definition; reference by derive.py"],
        "how_obtained": "Newton's equations of points; extrapolation of order 14, H = 1/250 s, and of order "
        f"12, H = 1/400 s, in 64-bit mantissa, agree to {common} digits",
        "digits": int(common),
        "bodies": [
            {"name": name, "mass": 1.0, "inertia": [0.01] * 3 + [0, 0, 0], "r0": r0}
            for name, r0 in zip(names, at)
        ],
        "joints": [],
        "forces": forces,
        "gravity": [0, 0, -9.81],
        "initial_conditions": "in a plane, 1 m apart, at rest; two sides tied to the ground",
        "quantities": ["t", "middle_z", "middle_vz", "corner_y", "corner_z"],
        "values": np.column_stack([times, *kept]).astype(float).tolist(),
    }


# torques (N m) of an arm at its joints, held over HOLD s each
HOLD = real(1) / 500


def arm_torques(n):
    """(n, 2) N m at the times k HOLD, in double precision: what goes into an input."""
    t = np.arange(n) * float(HOLD)
    return np.column_stack([8 * np.sin(3 * t), 4 * np.cos(5 * t)])


def arm_file(until):
    """Two bars of 1 m and 1 kg as an arm, from straight down, by torques that change every 2 ms."""
    f, x = chain(2, real(0))
    torques = arm_torques(round(until / float(HOLD)))

    def run(parts, order):
        now, rows = x, []

        for first, second in torques.astype(real):

            def driven(x, first=first, second=second):
                q, rate = x[:2], f(x)
                c = np.cos(q[0] - q[1]) / 2
                M = np.array([[real(4) / 3, c], [c, real(1) / 3]])
                return rate + np.concatenate(
                    [np.zeros(2, real), solved(M, np.array([first - second, second]))]
                )

            for _ in range(parts):
                now = extrapolated(driven, now, HOLD / parts, order)

            rows.append(now)

        return np.array(rows)

    every = round(1 / (4 * float(HOLD)))
    rows = run(1, 10)[every - 1 :: every]
    common = digits_of(rows, run(2, 8)[every - 1 :: every])
    times = (np.arange(len(rows)) + 1) * every * HOLD
    bodies = [
        {"name": f"bar{k + 1}", "mass": 1.0, "inertia": [0.001, 1 / 12, 1 / 12, 0, 0, 0],
         "r0": [0, -0.5 - k, 0], "q0": [float(np.sqrt(real(1) / 2)), 0, 0, -float(np.sqrt(real(1) / 2))]}
        for k in range(2)
    ]  # fmt: skip
    names = ["t", "theta1", "theta2", "theta1d", "theta2d"]
    return {
        "id": "arm_held_torques",
        "title": f"Two bars as an arm, driven by torques that change every {1e3 * float(HOLD):g} ms",
        "source": ["own definition; reference by derive.py"],
        "how_obtained": "Lagrange's equations, torques held over each 2 ms; extrapolation of order 10, H = 2 "
        f"ms, and of order 8, H = 1 ms, in 64-bit mantissa, agree to {common} digits",
        "digits": int(common),
        "bodies": bodies,
        "joints": [revolute("ground", "bar1", [0, 0, 0]), revolute("bar1", "bar2", [0, -1, 0])],
        "forces": [],
        "gravity": [0, -9.81, 0],
        "initial_conditions": "straight down, at rest",
        "quantities": names,
        "values": np.column_stack([times, rows]).astype(float).tolist(),
    }


# a bar of 1 m and 1 kg that falls against a stop: angle (rad) from the lowest position, stiffness, N m/rad
STOP, BUFFER = real("0.3"), real(20000)


def struck_rate(beyond):
    """x' of x = (angle, rate) of the bar before its stop, or beyond."""

    def f(x):
        push = BUFFER * (x[0] - STOP) if beyond else real(0)
        return np.array([x[1], -(G / 2 * np.sin(x[0]) + push) * 3])

    return f


def struck(start, times, H, order):
    """x at the times; each step ends where the bar meets or leaves the stop, which is found by bisection."""
    x, t, rows, beyond = np.array([start, 0], real), real(0), [], False

    for until in times:
        while t < until:
            f, step = struck_rate(beyond), min(H, until - t)
            new = extrapolated(f, x, step, order)

            if (new[0] > STOP) != beyond:
                low, high = real(0), step

                while high - low > real(10) ** -19:
                    middle = (low + high) / 2
                    inside = (extrapolated(f, x, middle, order)[0] > STOP) == beyond
                    low, high = (middle, high) if inside else (low, middle)

                new, step, beyond = extrapolated(f, x, high, order), high, not beyond
                new[0] = STOP

            x, t = new, until if step == until - t else t + step

        rows.append(x)

    return np.array(rows)


def struck_file(start, times):
    """The problem as a dict; start : rad."""
    rows = struck(start, times, real(1) / 1500, 10)
    common = digits_of(rows, struck(start, times, real(1) / 2000, 8))
    half = (float(start) - np.pi / 2) / 2
    middle = [0.5 * float(np.sin(start)), -0.5 * float(np.cos(start)), 0]
    return {
        "id": "bar_on_a_stop",
        "title": "A bar that falls against an elastic stop, over and over",
        "source": ["own definition; reference by derive.py"],
        "how_obtained": "steps end where the stop is met and left; extrapolation of order 10, H = 1/1500 s, "
        f"and of order 8, H = 1/2000 s, in 64-bit mantissa, agree to {common} digits",
        "digits": int(common),
        "stop": {"upper": float(STOP), "stiffness": float(BUFFER)},
        "bodies": [
            {"name": "bar1", "mass": 1.0, "inertia": [0.001, 1 / 12, 1 / 12, 0, 0, 0], "r0": middle,
             "q0": [float(np.cos(half)), 0, 0, float(np.sin(half))]}
        ],
        "joints": [revolute("ground", "bar1", [0, 0, 0])],
        "forces": [],
        "gravity": [0, -9.81, 0],
        "initial_conditions": f"{float(start):g} rad from the lowest position, at rest",
        "quantities": ["t", "theta1", "theta1d"],
        "values": np.column_stack([times, rows]).astype(float).tolist(),
    }  # fmt: skip


def text_of(data):
    """JSON with one row to a line."""
    lines = []

    for key, value in data.items():
        if isinstance(value, list) and value and isinstance(value[0], (list, dict)):
            rows = ",\n".join(f"  {json.dumps(row)}" for row in value)
            lines.append(f' "{key}": [\n{rows}\n ]')
        else:
            lines.append(f' "{key}": {json.dumps(value)}')

    return "{\n" + ",\n".join(lines) + "\n}\n"


def main(names):
    """Writes the files of these names; all without."""
    halves = np.arange(1, 11) * real(1) / 2
    quarters = np.arange(1, 21) * real(1) / 4
    tenths = np.arange(1, 11) * real(1) / 10
    files = {
        "chain_bars_N7": lambda: chain_file(7, np.pi * real(1) / 3, halves),
        "four_bar": lambda: four_bar_file(np.pi * real(1) / 3, quarters),
        "scissor_lift_100": lambda: lift_file(100, real("0.6"), tenths * 2),
        "spring_net_12": lambda: net_file(12, tenths),
        "arm_held_torques": lambda: arm_file(5.0),
        "bar_on_a_stop": lambda: struck_file(real(-1), halves),
    }

    for name in names or files:
        data = files[name]()
        print(data["id"], data["how_obtained"])
        (HERE / f"{data['id']}.json").write_text(text_of(data), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
