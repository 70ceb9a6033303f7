"""What links look like: forms and meshes of a URDF file as shapes of a scene."""

import os
import re
from dataclasses import dataclass
from pathlib import Path

from ..errors import quoted, show
from ..meshes import ENDINGS
from .elements import Reading

FORMS = {
    "box": {"size": 3},
    "cylinder": {"radius": 1, "length": 1},
    "sphere": {"radius": 1},
    "capsule": {"radius": 1, "length": 1},
}
"""Forms and their numbers, as both URDF and a scene have them."""


@dataclass
class Visual:
    """A look of a link. origin : (xyz, rpy). form : as a shape of a scene, of a mesh with the name that the file gives. material :
    its name, or None.
    """

    origin: tuple
    form: dict
    material: str | None


def read_visuals(reading: Reading, link, origin):
    """The `Visual`s of a link's element; `origin` reads an element's place."""
    found = []

    for element in link.findall("visual"):
        geometry = reading.child(element, "geometry", needed=True)
        form = _form(reading, geometry) if geometry is not None else None
        material = reading.child(element, "material")

        if form:
            found.append(
                Visual(origin(reading, element), form, None if material is None else material.get("name"))
            )

    return found


def _form(reading, geometry):
    forms = [child for child in geometry if isinstance(child.tag, str)]

    if not forms:
        reading.left_out["<geometry> of a link: is empty"] += 1
        return None

    form = forms[0]

    if form.tag == "mesh":
        file = reading.text(form, "filename")
        scale = reading.numbers(form, "scale", 3, (1.0,) * 3)

        if not file or 0.0 in scale:
            return None

        return {"mesh": {"file": file} | ({"scale": _scale(scale)} if scale != (1.0,) * 3 else {})}

    if form.tag not in FORMS:
        return None  # told with what is not read

    values = {key: reading.numbers(form, key, count) for key, count in FORMS[form.tag].items()}

    if min(min(numbers) for numbers in values.values()) <= 0.0:
        reading.left_out[f"<{form.tag}> of a link: without an extent"] += 1
        return None

    return {
        form.tag: {key: list(numbers) if key == "size" else numbers[0] for key, numbers in values.items()}
    }


def _scale(scale):
    return scale[0] if len(set(scale)) == 1 else list(scale)


def read_colours(reading: Reading, root):
    """{material: (red, green, blue, alpha) from 0 to 1}, of those that say a colour."""
    found = {}

    for material in root.iter("material"):
        if material.getparent().tag in ("robot", "visual") and (colour := material.find("color")) is not None:
            rgba = reading.numbers(colour, "rgba", 4)
            found.setdefault(material.get("name"), tuple(min(max(x, 0.0), 1.0) for x in rgba))

    return found


class Looks:
    """Makes shapes of visuals.

    lost : {mesh's name in the file: why it is not shown}.
    """

    def __init__(self, colours, options, path):
        self.colours, self.options = colours, options
        self.folder = Path(os.path.abspath(path)).parent
        self.lost = {}

    def shapes(self, visuals, place):
        """Shapes of a scene; `place` gives the keys of an origin."""
        return [shape for visual in visuals if (shape := self._shape(visual, place))]

    def _shape(self, visual, place):
        form = dict(visual.form)

        if "mesh" in form:
            path, why = self._path(form["mesh"]["file"])

            if why:
                self.lost[visual.form["mesh"]["file"]] = why
                return None

            form["mesh"] = form["mesh"] | {"file": path.as_posix()}

        red, green, blue, alpha = self.colours.get(visual.material, (None, None, None, 1.0))
        shape = form | place(visual.origin)

        if red is not None and alpha > 0.0:
            shape["colour"] = "#" + "".join(f"{round(255 * part):02x}" for part in (red, green, blue))
        if 0.0 < alpha < 1.0:
            shape["opacity"] = alpha

        return shape

    def _path(self, name):
        """(path of a mesh, None), or (None, why there is none)."""
        scheme = re.match(r"(package|model|file)://", name)
        rest = name[scheme.end() :] if scheme else name

        if scheme and scheme[1] != "file":
            package, _, rest = rest.partition("/")
            folders = self._packages(package)
            paths = [folder / rest for folder in folders]

            if not folders:
                return (
                    None,
                    f"no folder of the package {quoted(package)} found; --package {package}=DIR names it",
                )
        else:
            paths = [self.folder / rest]

        path = next((path for path in paths if path.is_file()), None)

        if path is None:
            return None, f"not there, in {show(str(paths[0].parent), limit=200)}"
        if path.suffix.lower() not in ENDINGS:
            return None, f"no mesh that can be read ({', '.join(ENDINGS)})"

        return path, None

    def _packages(self, package):
        """Folders that may be those of a package: what was said, else those above the file, and ROS_PACKAGE_PATH."""
        if package in self.options.packages:
            return [Path(os.path.abspath(self.options.packages[package]))]

        above = [self.folder, *self.folder.parents]
        told = [Path(folder) for folder in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if folder]
        folders = [
            folder for folder in [*above, *told] if folder.name == package or _package_name(folder) == package
        ]
        return folders + [folder / package for folder in [*above, *told] if (folder / package).is_dir()]


def _package_name(folder):
    """The name that a folder's package.xml gives, or None."""
    try:
        text = (folder / "package.xml").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return None
    found = re.search(r"<name>\s*([^<]*?)\s*</name>", text)
    return found[1] if found else None
