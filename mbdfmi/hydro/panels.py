"""Coefficients of a hull by capytaine, linear potential theory on panels (extra `hydro`): the mesh made
ready, problems solved one frequency after the other and kept, so that a run that was cut off goes on.
"""

import hashlib
import logging
import zipfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from ..files import replacing
from ..native.sources import cache_directory
from .database import DOFS, Coefficients
from .hdf import coefficients_of
from .spectra import wave_number

# panels by the shortest wave, at most so many
PANELS_A_WAVE = 8
MOST_PANELS = 6000

# of the hull's size: vertices this near to the water plane are on it
FLAT = 1e-9

# parts of panels' size by which a lid, or a plate, must be under the water
UNDER = 0.2


@dataclass(frozen=True)
class Wet:
    """What of a hull is under water, its outside on the left of its triangles.

    vertices : (n, 3) m. faces : (m, 3). volume : m3. waterplane : m2. center : (3,) m, of buoyancy.
    """

    vertices: np.ndarray
    faces: np.ndarray
    volume: float
    waterplane: float
    center: np.ndarray

    @property
    def edge(self) -> float:
        """m, the longest edge."""
        return float(
            np.linalg.norm(self.vertices[self.faces] - np.roll(self.vertices[self.faces], 1, 1), axis=2).max()
        )

    def finer(self, edge) -> "Wet":
        """With no edge longer than this (m)."""
        if self.edge <= edge:
            return self

        vertices, faces = trimesh.remesh.subdivide_to_size(self.vertices, self.faces, edge, max_iter=20)
        return replace(self, vertices=np.asarray(vertices), faces=np.asarray(faces))


def wet_part(path, scale=1.0) -> Wet:
    """The wet surface of a file of triangles, z up, the water plane at z = 0.

    scale : m, its unit. Raises ValueError that names the file: unreadable, out of the water, with a hole
    under it.
    """
    try:
        mesh: Any = trimesh.load(path, force="mesh")
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror or error}") from None
    except Exception as error:
        raise ValueError(f"{path}: cannot be read as a mesh: {error}") from None

    if not len(getattr(mesh, "faces", ())):
        raise ValueError(f"{path}: holds no triangles")

    mesh.apply_scale(scale)
    mesh.merge_vertices()
    size = float(np.ptp(mesh.vertices, axis=0).max())
    mesh.vertices[np.abs(mesh.vertices[:, 2]) < FLAT * size, 2] = 0.0

    if mesh.vertices[:, 2].min() >= 0.0:
        raise ValueError(
            f"{path}: is all above z = 0, the water plane; its lowest point is at "
            f"{mesh.vertices[:, 2].min():g} m"
        )

    under = trimesh.intersections.slice_faces_plane(mesh.vertices, mesh.faces, [0, 0, -1], [0, 0, 0])
    wet: Any = trimesh.Trimesh(vertices=under[0], faces=under[1], process=False)
    flat = (np.abs(wet.vertices[wet.faces][:, :, 2]) < FLAT * size).all(axis=1)
    wet.update_faces(~flat & wet.nondegenerate_faces())
    wet.merge_vertices()
    wet.remove_unreferenced_vertices()
    trimesh.repair.fix_winding(wet)
    _check_closed(path, wet, size)
    return _measured(path, wet)


def _check_closed(path, wet, size):
    """Raises ValueError with the place of an edge under water that one triangle alone has."""
    edges, counts = np.unique(np.sort(wet.edges, axis=1), axis=0, return_counts=True)
    open_edges = edges[counts == 1]
    ends = wet.vertices[open_edges]
    under = (ends[:, :, 2] < -FLAT * size).any(axis=1)

    if under.any():
        x, y, z = ends[under].mean(axis=1)[0]
        raise ValueError(
            f"{path}: has a hole under water, {under.sum()} edges of one triangle alone, the first at "
            f"({x:.4g}, {y:.4g}, {z:.4g}) m"
        )
    if (counts > 2).any():
        x, y, z = wet.vertices[edges[counts > 2][0]].mean(axis=0)
        raise ValueError(f"{path}: more than two triangles meet at ({x:.4g}, {y:.4g}, {z:.4g}) m")


def _measured(path, wet):
    """The wet part with its volume; turned inside out where that is negative."""
    a, b, c = (wet.vertices[wet.faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a) / 2

    # of z over the surface, times the upward part of its normal; the water plane itself adds nothing
    volume = float(((a + b + c)[:, 2] / 3 * normal[:, 2]).sum())
    turned = np.sign(volume) or 1.0

    if not abs(volume) > 0.0:
        raise ValueError(f"{path}: displaces nothing")

    normal, volume = turned * normal, turned * volume
    squares = sum((p + q) ** 2 for p, q in ((a, b), (b, c), (c, a))) / 12
    moments = (squares * normal).sum(axis=0) / 2
    faces = wet.faces if turned > 0 else wet.faces[:, ::-1]
    return Wet(np.array(wet.vertices), np.array(faces), volume, float(-normal[:, 2].sum()), moments / volume)


def panel_edge(omega, depth, gravity) -> float:
    """m, an eighth of the shortest wave."""
    return float(2 * np.pi / wave_number(np.max(omega), depth, gravity) / PANELS_A_WAVE)


@dataclass(frozen=True)
class Problem:
    """What is solved: omega (n,) rad/s, headings (h,) rad, depth in m or None, reference (3,) m of the
    coefficients, a lid inside.
    """

    omega: np.ndarray
    headings: np.ndarray
    density: float
    gravity: float
    depth: float | None = None
    reference: tuple = (0.0, 0.0, 0.0)
    lid: bool = False


def solve(wet: Wet, problem: Problem, progress: Callable[[float, str], None] | None = None) -> Coefficients:
    """Coefficients of a hull. Each frequency is kept in the cache folder until all are there.

    progress : called with the part that is done and words. Raises ValueError without capytaine, and for a
    hull with too many panels.
    """
    try:
        import capytaine
    except ImportError:
        raise ValueError('needs capytaine: pip install "mbdfmi[hydro]"') from None

    if len(wet.faces) > MOST_PANELS:
        raise ValueError(
            f"{len(wet.faces)} panels need hours, and {16e-9 * len(wet.faces) ** 2:.0f} GB; take a coarser "
            "mesh or a longer --panel"
        )

    logging.getLogger("capytaine").setLevel(logging.ERROR)
    body, solver = _body(capytaine, wet, problem), capytaine.BEMSolver()
    folder, parts = cache_directory() / "hydro" / _digest(wet, problem), []

    for k, omega in enumerate(problem.omega):
        if progress:
            progress(k / len(problem.omega), f"{omega:.4g} rad/s")

        parts.append(
            _kept(folder / f"{omega:.12g}.npz", lambda w=omega: _solved(capytaine, solver, body, problem, w))
        )

    added, damping, excitation = (
        np.array([part[name] for part in parts]) for name in ("added", "damping", "excitation")
    )
    return Coefficients(problem.omega, added, damping, None, problem.omega, problem.headings, excitation)


def _body(capytaine, wet, problem):
    mesh = capytaine.Mesh(vertices=wet.vertices, faces=wet.faces)
    dofs = capytaine.rigid_body_dofs(rotation_center=problem.reference)
    lid = (
        mesh.generate_lid(z=mesh.lowest_lid_position(omega_max=float(np.max(problem.omega))))
        if problem.lid
        else None
    )
    return capytaine.FloatingBody(mesh=mesh, lid_mesh=lid, dofs=dofs, name="hull")


def _solved(capytaine, solver, body, problem, omega):
    """{name: array} of one frequency."""
    water = {
        "rho": problem.density, "g": problem.gravity, "omega": omega,
        "water_depth": np.inf if problem.depth is None else problem.depth,
    }  # fmt: skip
    problems = [capytaine.RadiationProblem(body=body, radiating_dof=dof, **water) for dof in body.dofs]
    problems += [capytaine.DiffractionProblem(body=body, wave_direction=b, **water) for b in problem.headings]
    results = solver.solve_all(problems, keep_details=False, progress_bar=False)
    found = coefficients_of(capytaine.assemble_dataset(results))
    return {
        "added": found.added[0],
        "damping": found.damping[0],
        "excitation": np.asarray(found.excitation)[0],
    }


def _digest(wet, problem):
    """Hash of all that the results are made of, but for the frequencies."""
    digest = hashlib.sha256(
        repr(replace(problem, omega=np.max(problem.omega) if problem.lid else None)).encode()
    )

    for array in (wet.vertices, wet.faces.astype(float), problem.headings):
        digest.update(np.ascontiguousarray(array, "<f8").tobytes())

    return digest.hexdigest()[:24]


def _kept(path: Path, make):
    """What a file holds, or what is made and written there."""
    with (
        suppress(OSError, ValueError, KeyError, zipfile.BadZipFile),
        np.load(path, allow_pickle=False) as found,
    ):
        return {name: found[name] for name in ("added", "damping", "excitation")}

    made = make()

    # where nothing can be kept it is solved again the next time
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)

        with replacing(path) as temporary, open(temporary, "wb") as file:
            np.savez(file, **made)

    return made


def hydrostatic_heave(coefficients: Coefficients, waterplane, density, gravity) -> float:
    """By how much (a part) the heave force of the longest waves is off rho g times the waterplane, where
    there is one.
    """
    force = abs(np.asarray(coefficients.excitation)[0, 0, DOFS.index("heave")])
    return float(force / (density * gravity * waterplane) - 1.0)
