"""What the library of an FMU reads when it is instantiated: resources/model.bin."""

import struct
import zlib

import numpy as np

from ..compiler.model import SEALED_SIZES, sealed
from .tape import NONE, Tape

NAME = "model.bin"
MAGIC = b"mbdfmi\0\1"
VERSION = 10
TAPE_SIZES = ("operations", "constants", "guards", "led_guards", "results")
REST_SIZES = ("rest", "rests")
SIZES = (*SEALED_SIZES, "places", "messages", "notices", *TAPE_SIZES, *REST_SIZES)
GUID_SIZE = 64


def resource(model, messages: dict[int, str], tape: Tape = NONE) -> bytes:
    """The resource file of a model: sizes, arrays, variables, tape, start at rest, names; `messages` are texts of status codes.

    The layout (little endian) is described in fmu_src/resource.h.
    """
    strings = [*(v.name for v in model.listed), *model.places]
    for code, text in messages.items():
        strings += [str(code), text]
    strings += model.notices

    sizes, numbers = sealed(model)
    rest = np.stack([model.rest.x, model.rest.rates]) if model.rest else np.zeros((2, 0))
    rests = rest.shape[1], int(bool(model.rest and model.rest.asked))
    counts = len(model.places), len(messages), len(model.notices), *tape.sizes, *rests
    body = sizes + struct.pack(f"<{len(counts)}q", *counts)
    body += model.guid.encode().ljust(GUID_SIZE, b"\0")
    body += numbers + tape.data() + rest.astype("<f8").tobytes()
    body += b"".join(text.encode() + b"\0" for text in strings)

    return MAGIC + struct.pack("<IIQ", VERSION, zlib.crc32(body), len(body)) + body
