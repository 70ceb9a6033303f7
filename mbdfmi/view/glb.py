"""A writer of GLB: nodes, meshes, one animation in binary glTF 2.0
(https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html).

Own code: of the libraries, those that write animations (pygltflib) leave all of the packing to their user
and bring six more packages, and trimesh's exporter writes no animations.
"""

import json
import struct
from dataclasses import dataclass, field
from typing import Any

import numpy as np

FLOAT, SHORT, INT = 5126, 5123, 5125
TYPES = {(): "SCALAR", (3,): "VEC3", (4,): "VEC4"}
ARRAY, ELEMENTS = 34962, 34963


@dataclass
class Node:
    """A node of the scene, placed in its parent by r (3,) in m, q (4,), scale (3,) or none.

    surfaces : (Triangles, colour (3,) sRGB, opacity), drawn in its axes. moves : the channels "translation",
        "rotation", "scale" (n, 3 or 4) and "weights" (n, targets) over the times of the animation. targets :
        (points, 3) m each, by which the points of its one surface move, times the weights.
    """

    name: str
    r: np.ndarray | None = None
    q: np.ndarray | None = None
    scale: np.ndarray | None = None
    surfaces: list = field(default_factory=list)
    children: list = field(default_factory=list)
    moves: dict = field(default_factory=dict)
    targets: list = field(default_factory=list)
    extras: dict = field(default_factory=dict)


def write(root: Node, times, title) -> bytes:
    """The GLB of a tree of nodes; times (n,), s, of their moves."""
    writer = _Writer(np.asarray(times, np.float64), title)
    writer.document["scenes"][0]["nodes"].append(writer.node(root))
    return writer.bytes()


class _Writer:
    def __init__(self, times, title):
        self.times, self.time = times, None
        self.blobs, self.length = [], 0
        self.materials = {}
        self.channels, self.samplers = [], []
        self.document: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": "mbdfmi"},
            "scene": 0,
            "scenes": [{"name": title, "nodes": []}],
            "nodes": [],
            "meshes": [],
            "materials": [],
            "accessors": [],
            "bufferViews": [],
        }

    def node(self, node):
        """Adds a node and all below it; returns its index."""
        data = {"name": node.name}

        for key, value in (("translation", node.r), ("rotation", node.q), ("scale", node.scale)):
            if value is not None:
                data[key] = np.asarray(value, np.float64).tolist()

        data |= {"extras": node.extras} if node.extras else {}
        index = len(self.document["nodes"])
        self.document["nodes"].append(data)

        if node.surfaces:
            data["mesh"] = self._mesh(node.name, node.surfaces)

        if node.targets:
            mesh = self.document["meshes"][data["mesh"]]
            mesh["weights"] = np.asarray(node.moves["weights"][0], np.float64).tolist()
            mesh["primitives"][0]["targets"] = [
                {"POSITION": self._array(target, FLOAT, ARRAY, bounds=True)} for target in node.targets
            ]

        for path, values in node.moves.items():
            self._channel(index, path, values)

        if node.children:
            data["children"] = [self.node(child) for child in node.children]

        return index

    def _mesh(self, name, surfaces):
        primitives = []

        for surface, colour, opacity in surfaces:
            indices = SHORT if len(surface.points) < 65535 else INT
            primitives.append(
                {
                    "attributes": {
                        "POSITION": self._array(surface.points, FLOAT, ARRAY, bounds=True),
                        "NORMAL": self._array(surface.normals, FLOAT, ARRAY),
                    },
                    "indices": self._array(surface.faces.ravel(), indices, ELEMENTS),
                    "material": self._material(colour, opacity),
                }
            )

        self.document["meshes"].append({"name": name, "primitives": primitives})
        return len(self.document["meshes"]) - 1

    def _material(self, colour, opacity):
        key = tuple(colour), opacity

        if key not in self.materials:
            # glTF's factors are linear, names of colours are sRGB
            c = np.asarray(colour, float)
            linear = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
            material = {
                "pbrMetallicRoughness": {
                    "baseColorFactor": [*(round(float(x), 6) for x in linear), opacity],
                    "metallicFactor": 0.1,
                    "roughnessFactor": 0.6,
                },
                "doubleSided": True,
            }
            self.materials[key] = len(self.materials)
            self.document["materials"].append(material | ({"alphaMode": "BLEND"} if opacity < 1 else {}))

        return self.materials[key]

    def _channel(self, node, path, values):
        if self.time is None:
            self.time = self._array(self.times, FLOAT, None, bounds=True)

        # glTF has the weights of a time one after another
        values = values.ravel() if path == "weights" else values
        self.samplers.append({"input": self.time, "output": self._array(values, FLOAT, None)})
        self.channels.append({"sampler": len(self.samplers) - 1, "target": {"node": node, "path": path}})

    def _array(self, values, kind, target, bounds=False):
        """Adds an accessor and its view; returns its index."""
        dtype = {FLOAT: "<f4", SHORT: "<u2", INT: "<u4"}[kind]
        values = np.ascontiguousarray(values, dtype)
        blob = values.tobytes()
        blob += b"\0" * (-len(blob) % 4)
        view = {"buffer": 0, "byteOffset": self.length, "byteLength": values.nbytes}
        self.document["bufferViews"].append(view | ({"target": target} if target else {}))
        self.blobs.append(blob)
        self.length += len(blob)
        accessor = {
            "bufferView": len(self.document["bufferViews"]) - 1,
            "componentType": kind,
            "count": len(values),
            "type": TYPES[values.shape[1:]],
        }

        if bounds:
            least, most = values.min(axis=0), values.max(axis=0)
            accessor |= {"min": np.atleast_1d(least).tolist(), "max": np.atleast_1d(most).tolist()}

        self.document["accessors"].append(accessor)
        return len(self.document["accessors"]) - 1

    def bytes(self):
        """The file."""
        document = self.document | {"buffers": [{"byteLength": self.length}]}

        if self.channels:
            document["animations"] = [{"name": "run", "channels": self.channels, "samplers": self.samplers}]

        # glTF has no empty lists
        document = {key: value for key, value in document.items() if value != []}

        if not self.length:
            del document["buffers"]

        text = json.dumps(document, separators=(",", ":"), ensure_ascii=False, allow_nan=False).encode()
        text += b" " * (-len(text) % 4)
        binary = b"".join(self.blobs)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text

        if binary:
            chunks += struct.pack("<I4s", len(binary), b"BIN\0") + binary

        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def read(data: bytes):
    """(document, arrays) of a GLB: its JSON, and the numpy array of each of its accessors."""
    length = struct.unpack_from("<I", data, 12)[0]
    document = json.loads(data[20 : 20 + length])
    binary = data[28 + length :]
    arrays = []

    for accessor in document.get("accessors", []):
        view = document["bufferViews"][accessor["bufferView"]]
        kind = {FLOAT: "<f4", SHORT: "<u2", INT: "<u4"}[accessor["componentType"]]
        shape = next(shape for shape, name in TYPES.items() if name == accessor["type"])
        values = np.frombuffer(binary, kind, accessor["count"] * int(np.prod(shape)), view["byteOffset"])
        arrays.append(values.reshape(accessor["count"], *shape))

    return document, arrays
