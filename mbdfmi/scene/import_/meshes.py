"""Meshes of looks, from where a scene file is: as they are, or thinned copies beside it."""

import os
from pathlib import Path

from ...files import replacing
from .imported import Imported
from .names import Names

THINNED = "_meshes"
"""What the name of the folder of thinned meshes has beyond that of the scene file."""


def place_meshes(imported: Imported, scene_file, faces=None):
    """Names the meshes of an `Imported` as a scene file of that name does.

    faces : triangles that a mesh may have; of one with more a thinned copy goes into a folder beside the scene file. None: as many as
    it has. Raises ValueError, OSError.
    """
    scene_file = Path(os.path.abspath(scene_file))
    folder, names, copies = scene_file.parent / (scene_file.stem + THINNED), Names("mesh"), {}

    for mesh in _meshes(imported.tables):
        path = Path(mesh["file"])

        if faces and path not in copies:
            copies[path] = _thinned(path, faces, lambda path=path: folder / f"{names.new(path.stem)}.glb")

        mesh["file"] = _relative(copies.get(path, path), scene_file.parent)

    thinned = [path for path, copy in copies.items() if copy != path]

    if thinned:
        what = "1 mesh is" if len(thinned) == 1 else f"{len(thinned)} meshes are"
        imported.decided.append(f"{what} thinned to {faces} triangles, in {folder.name}/")


def _meshes(table):
    """All meshes of shapes in tables of a scene."""
    if isinstance(table, dict):
        for key, value in table.items():
            if key == "mesh" and "file" in value:
                yield value
            else:
                yield from _meshes(value)
    elif isinstance(table, list):
        for item in table:
            yield from _meshes(item)


def _relative(path, folder):
    """The path as seen from the folder; itself where none leads there (another drive)."""
    try:
        return Path(os.path.relpath(path, folder)).as_posix()
    except ValueError:
        return Path(path).as_posix()


def _thinned(path, faces, copy):
    """The path of a mesh of at most about `faces` triangles: itself, or a copy in a file that `copy` names."""
    try:
        import fast_simplification  # noqa: F401  trimesh calls it
        import trimesh
    except ImportError as error:
        raise ValueError(
            f"--faces wants the package fast-simplification: pip install fast-simplification ({error})"
        ) from None

    try:
        parts = trimesh.load_scene(path).dump(concatenate=False)
        parts = [part for part in parts if isinstance(part, trimesh.Trimesh) and len(part.faces)]
        total = sum(len(part.faces) for part in parts)

        if total <= faces:
            return path

        thin = trimesh.Scene([_part_thinned(part, faces * len(part.faces) // total) for part in parts])
        data = thin.export(file_type="glb")
    except Exception as error:
        # readers of files from outside fail in as many ways as there are broken files
        raise ValueError(
            f"{path}: is no mesh that can be thinned ({type(error).__name__}: {error})"
        ) from None

    target = copy()

    with replacing(target) as unfinished:
        unfinished.write_bytes(data)

    return target


def _part_thinned(part, faces):
    """A part of a mesh of at most about so many triangles, in its main colour."""
    look = getattr(part.visual, "material", part.visual)
    colour = look.main_color if part.visual.defined else None

    # files of separate triangles say by places alone which corners are one
    part.merge_vertices(merge_tex=True, merge_norm=True)
    thin = (
        part.simplify_quadric_decimation(face_count=max(faces, 4))
        if len(part.faces) > max(faces, 4)
        else part
    )

    if colour is not None:
        thin.visual.face_colors = colour

    return thin
