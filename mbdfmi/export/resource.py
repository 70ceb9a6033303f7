"""What the library of an FMU reads when it is instantiated: resources/model.bin."""

import struct
import zlib

from ..compiler.model import SEALED_SIZES, sealed
from .tape import NONE, Tape

NAME = "model.bin"
MAGIC = b"mbdfmi\0\1"
VERSION = 6
TAPE_SIZES = ("operations", "constants", "guards", "led_guards", "results")
SIZES = (*SEALED_SIZES, "places", "messages", "notices", *TAPE_SIZES)
GUID_SIZE = 64


def resource(model, messages: dict[int, str], tape: Tape = NONE) -> bytes:
    """The resource file of a model: sizes, arrays, variables, tape, names; `messages` are texts of status codes.

    The layout (little endian) is described in fmu_src/resource.h.
    """
    strings = [*(v.name for v in model.listed), *model.places]
    for code, text in messages.items():
        strings += [str(code), text]
    strings += model.notices

    sizes, numbers = sealed(model)
    body = sizes + struct.pack("<8q", len(model.places), len(messages), len(model.notices), *tape.sizes)
    body += model.guid.encode().ljust(GUID_SIZE, b"\0")
    body += numbers + tape.data()
    body += b"".join(text.encode() + b"\0" for text in strings)

    return MAGIC + struct.pack("<IIQ", VERSION, zlib.crc32(body), len(body)) + body
