"""Makes the reference digits of `chain_bars_N7` and `four_bar`: `python -m benchmarks.reference.derive`.

Nothing of the kernels is used: Lagrange's equations in minimal coordinates, in extended precision (numpy's
longdouble, 64 bits of mantissa on x86), by extrapolation of the modified midpoint rule (Hairer, Norsett,
Wanner, Solving ODEs I, section II.9). Two runs of different order and step tell how many digits are right.
"""

import json
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


def main():
    """Writes both files."""
    halves = np.arange(1, 11) * real(1) / 2
    quarters = np.arange(1, 21) * real(1) / 4

    for data in (chain_file(7, np.pi * real(1) / 3, halves), four_bar_file(np.pi * real(1) / 3, quarters)):
        print(data["id"], data["how_obtained"])
        (HERE / f"{data['id']}.json").write_text(text_of(data), encoding="utf-8")


if __name__ == "__main__":
    main()
