"""Files of triangles: where they are, and the mass properties of what they enclose."""

import os
from functools import lru_cache
from pathlib import Path

import numpy as np

from .errors import show

ENDINGS = (".stl", ".obj", ".ply", ".off", ".glb", ".gltf", ".dae", ".3mf")


class MeshFile(str):
    """The name of a mesh file as a scene gives it, from the folder of the scene file.

    path : absolute.
    """

    path: Path

    def __new__(cls, name, folder):
        made = super().__new__(cls, name)
        made.path = Path(os.path.abspath(Path(folder) / name))
        return made

    def __getnewargs__(self):
        return str(self), self.path.parent


def mesh_file(value, info):
    """The type's validator: relative names start at the folder that the validation's context names, else here."""
    if isinstance(value, MeshFile):
        return value
    if not isinstance(value, str) or not value.strip():
        raise ValueError(f"needs the name of a mesh file in quotes, found {show(value)}")
    if Path(value).suffix.lower() not in ENDINGS:
        raise ValueError(f"needs a mesh ({', '.join(ENDINGS)}), found {show(value)}")
    return MeshFile(value, (info.context or {}).get("folder", "."))


def load_mesh(file, scale=1.0):
    """The `trimesh.Trimesh` of a mesh file, all its parts in one, scaled. scale : number or (3,).

    Raises ValueError that names the file.
    """
    import trimesh

    parts = [mesh for mesh, _ in mesh_parts(file, scale)]
    return parts[0] if len(parts) == 1 else trimesh.util.concatenate(parts)


def mesh_parts(file, scale=1.0):
    """[(`trimesh.Trimesh`, its main colour (3,) from 0 to 1 or None)] of the parts of a mesh file, scaled.

    Textures are no colour. scale : number or (3,). Raises ValueError that names the file.
    """
    stretch = np.diag([*np.broadcast_to(scale, 3), 1.0])
    return [
        (mesh.copy().apply_transform(stretch), colour) for mesh, colour in _read(str(file.path), _stamp(file))
    ]


def _stamp(file):
    """What changes when the file does. Raises ValueError when it is not there."""
    try:
        found = os.stat(file.path)
    except OSError as error:
        raise ValueError(f"{file.path}: {error.strerror}") from None
    return found.st_mtime_ns, found.st_size


@lru_cache(maxsize=256)
def _read(path, stamp):
    """[(part, colour)] of the mesh in a file; `stamp` : a changed file is read anew."""
    import trimesh

    try:
        alone = Path(path).suffix.lower() in (".stl", ".ply", ".off")
        found = [trimesh.load_mesh(path)] if alone else list(trimesh.load_scene(path).dump(concatenate=False))
        parts = [
            (part, _main_colour(part))
            for part in found
            if isinstance(part, trimesh.Trimesh) and len(part.faces)
        ]
    except ImportError as error:
        raise ValueError(f"{path}: cannot be read: {error}") from None
    except Exception as error:
        # readers of files from outside fail in as many ways as there are broken files
        raise ValueError(f"{path}: is no mesh that can be read ({type(error).__name__}: {error})") from None

    if not parts:
        raise ValueError(f"{path}: holds no triangles")
    if not all(np.isfinite(part.vertices).all() for part, _ in parts):
        raise ValueError(f"{path}: has vertices that are no finite numbers")
    return parts


def _main_colour(part):
    """(3,) from 0 to 1 of a part of a mesh that has a colour of its own, else None."""
    look = getattr(part.visual, "material", part.visual)
    textures = (getattr(look, name, None) for name in ("image", "baseColorTexture"))

    if not part.visual.defined or any(texture is not None for texture in textures):
        return None

    return tuple(float(x) / 255 for x in look.main_color[:3])


def enclosed(file, scale):
    """(volume m3, centre (3,) m, inertia (3, 3) per density about it, m5) of what a closed mesh encloses.

    Raises ValueError that names the holes of one that is not closed.
    """
    mesh = closed_mesh(file, scale, "a solid")
    volume, centre = float(mesh.volume), np.array(mesh.center_mass)
    mesh.density = 1.0
    inertia = np.array(mesh.moment_inertia)
    return volume, centre, (inertia + inertia.T) / 2


def closed_mesh(file, scale, what):
    """The `trimesh.Trimesh` of a mesh file, whose triangles turn left seen from outside.

    what : is made of it. Raises ValueError that names the holes of one that is not closed.
    """
    mesh = load_mesh(file, scale)

    # files of separate triangles say by places alone which corners are one
    mesh.merge_vertices(merge_tex=True, merge_norm=True)

    if not mesh.is_watertight:
        raise ValueError(f"{file.path}: {_holes(mesh)}; {what} needs a closed surface (as a look it will do)")
    if not mesh.is_winding_consistent:
        mesh.fix_normals(multibody=True)
    if mesh.volume < 0:
        mesh.invert()
    if not mesh.volume > 0:
        raise ValueError(f"{file.path}: encloses no volume")
    return mesh


def _holes(mesh):
    """Where the surface of a mesh is open, in words."""
    import trimesh

    once = trimesh.grouping.group_rows(mesh.edges_sorted, require_count=1)

    if not len(once):
        return "has edges at which more than two triangles meet"

    edges = mesh.edges_sorted[once]
    holes = trimesh.graph.connected_components(edges)
    largest = max(holes, key=lambda hole: np.ptp(mesh.vertices[hole], axis=0).max())
    corners = mesh.vertices[largest]
    across = np.linalg.norm(np.ptp(corners, axis=0))
    middle = ", ".join(f"{x:.4g}" for x in corners.mean(axis=0))
    count = "a hole" if len(holes) == 1 else f"{len(holes)} holes, the largest"
    return f"has {count} of {len(largest)} corners around [{middle}] m, {across:.3g} m across"
