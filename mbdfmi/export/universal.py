"""Libraries of Macs of both processors in one file, of which each takes its own."""

import struct

MAGIC = 0xCAFEBABE
"""Of such a file, big endian."""

SLICE = 0xFEEDFACF
"""Of the library of one processor, little endian."""

ALIGNMENT = 14
"""Slices begin at multiples of 2 to this power: the largest page that there is."""


def universal(slices: list[bytes]) -> bytes:
    """One file of the libraries of several processors."""
    head = struct.pack(">2I", MAGIC, len(slices))
    page = 1 << ALIGNMENT
    at, body = page, b""

    for data in slices:
        magic, processor, kind = struct.unpack_from("<3I", data)

        if magic != SLICE:
            raise ValueError("this is no library for a Mac")

        head += struct.pack(">5I", processor, kind, at, len(data), ALIGNMENT)
        padded = data + b"\0" * (-len(data) % page)
        body += padded
        at += len(padded)

    return head.ljust(page, b"\0") + body
