"""What the library of an FMU reads when it is instantiated: resources/model.bin."""

import struct
import zlib

from ..compiler.model import SEALED_SIZES, sealed

NAME = "model.bin"
MAGIC = b"mbdfmi\0\1"
VERSION = 5
SIZES = (*SEALED_SIZES, "places", "messages", "notices")
GUID_SIZE = 64


def resource(model, messages: dict[int, str]) -> bytes:
    """The resource file of a model: sizes, arrays, variables, names; `messages` are texts of status codes.

    The layout (little endian) is described in fmu_src/resource.h.
    """
    strings = [*(v.name for v in model.listed), *model.places]
    for code, text in messages.items():
        strings += [str(code), text]
    strings += model.notices

    sizes, numbers = sealed(model)
    body = sizes + struct.pack("<3q", len(model.places), len(messages), len(model.notices))
    body += model.guid.encode().ljust(GUID_SIZE, b"\0")
    body += numbers
    body += b"".join(text.encode() + b"\0" for text in strings)

    return MAGIC + struct.pack("<IIQ", VERSION, zlib.crc32(body), len(body)) + body
