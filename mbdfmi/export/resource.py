"""What the library of an FMU reads when it is instantiated: resources/model.bin."""

import struct
import zlib

from ..compiler.model import sealed

NAME = "model.bin"

_MAGIC = b"mbdfmi\0\1"
_VERSION = 3


def resource(model, messages: dict[int, str]) -> bytes:
    """The resource file of a model: sizes, arrays, names; `messages` are texts of status codes.

    The layout (little endian) is described in fmu_src/resource.h. Raises ValueError when the
    variables do not come in the order of value references.
    """
    parameters = model.of_causality("parameter")
    ordered = [*model.of_causality("input"), *model.of_causality("output"), *parameters]

    if list(model.variables) != ordered:
        raise ValueError("the variables must be the inputs, then the outputs, then the parameters")

    names = [v.name for v in model.variables]
    strings = [*names, *model.places]
    for code, text in messages.items():
        strings += [str(code), text]
    strings += model.notices

    sizes, numbers = sealed(model)
    body = sizes + struct.pack("<3q", len(model.places), len(messages), len(model.notices))
    body += model.guid.encode().ljust(64, b"\0")
    body += numbers
    body += b"".join(text.encode() + b"\0" for text in strings)

    return _MAGIC + struct.pack("<IIQ", _VERSION, zlib.crc32(body), len(body)) + body
