"""Makes barge.1 and barge.3: coefficients of the barge by capytaine (pip install "mbdfmi[hydro]" capytaine), five minutes.

The moonpool of 10 x 10 m is covered, as in the published model: half a metre under the waterline, since a plate just below the
surface resonates with what water is over it. A lid inside keeps irregular frequencies away. Above 2.1 rad/s the water over the
plate sloshes after all, so that is where it ends; damping falls with the third power of the frequency from there on.
"""

import logging
from pathlib import Path

import capytaine as cpt
import numpy as np

from mbdfmi.hydro.hdf import coefficients_of
from mbdfmi.hydro.wamit import write_wamit

HERE = Path(__file__).parent
DENSITY, GRAVITY = 1025.0, 9.80665
HALF, POOL, DRAUGHT, COVER = 20.0, 5.0, 4.0, -0.5  # m
PANEL = 1.4  # m, at most about

OMEGA = np.concatenate(
    [[0.05], np.arange(0.1, 0.4, 0.1), np.arange(0.4, 1.3, 0.06), np.arange(1.3, 2.1, 0.12)]
)
HEADINGS = np.radians(np.arange(0.0, 360.0, 30.0))


def patch(a, b, c, d):
    """(points, quadrilaterals) of a rectangle by its corners, which turn left seen from the water."""
    a, b, c, d = (np.array(x, float) for x in (a, b, c, d))
    n, m = (max(1, round(np.linalg.norm(x) / PANEL)) for x in (b - a, d - a))
    points = [a + (b - a) * i / n + (d - a) * j / m for j in range(m + 1) for i in range(n + 1)]
    faces = [[k, k + 1, k + n + 2, k + n + 1] for j in range(m) for k in range(j * (n + 1), j * (n + 1) + n)]
    return np.array(points), np.array(faces)


def walls(half, low, high, outwards):
    """The four walls of a square, from `low` to `high`."""
    corners = [(-half, -half), (half, -half), (half, half), (-half, half)]

    for (x, y), (u, v) in zip(corners, corners[1:] + corners[:1]):
        (x, y), (u, v) = ((x, y), (u, v)) if outwards else ((u, v), (x, y))
        yield patch((x, y, low), (u, v, low), (u, v, high), (x, y, high))


def floor(x, y, z):
    """A rectangle between two x and two y, seen from below."""
    return patch((x[0], y[0], z), (x[0], y[1], z), (x[1], y[1], z), (x[1], y[0], z))


def mesh():
    """The wet surface of the barge."""
    edges = [-HALF, -POOL, POOL, HALF]
    cells = [(i, j) for i in range(3) for j in range(3) if (i, j) != (1, 1)]
    parts = [*walls(HALF, -DRAUGHT, 0.0, True), *walls(POOL, -DRAUGHT, COVER, False)]
    parts += [floor(edges[i : i + 2], edges[j : j + 2], -DRAUGHT) for i, j in cells]
    parts.append(floor([-POOL, POOL], [-POOL, POOL], COVER))
    first = np.cumsum([0] + [len(points) for points, _ in parts])
    faces = np.vstack([quads + k for (_, quads), k in zip(parts, first)])
    return cpt.Mesh(vertices=np.vstack([points for points, _ in parts]), faces=faces)


def main():
    """Solves all problems and writes the files."""
    logging.disable(logging.WARNING)
    hull = mesh()
    dofs = cpt.rigid_body_dofs(rotation_center=(0, 0, 0))
    body = cpt.FloatingBody(mesh=hull, lid_mesh=hull.generate_lid(z=-0.05), dofs=dofs, name="barge")
    solver, results, water = cpt.BEMSolver(), [], {"rho": DENSITY, "g": GRAVITY}
    print(f"{hull.nb_faces} panels, {hull.volume:.1f} m3")

    for omega in OMEGA:
        problems = [cpt.RadiationProblem(body=body, radiating_dof=dof, omega=omega, **water) for dof in dofs]
        problems += [
            cpt.DiffractionProblem(body=body, wave_direction=b, omega=omega, **water) for b in HEADINGS
        ]
        results += solver.solve_all(problems, keep_details=False, progress_bar=False)
        print(f"{omega:.3g} rad/s", flush=True)

    coefficients, notes = coefficients_of(cpt.assemble_dataset(results)).checked()
    print("\n".join(notes))
    write_wamit(HERE / "barge.1", coefficients, DENSITY, GRAVITY)


if __name__ == "__main__":
    main()
