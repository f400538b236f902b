"""What `app.service.packing` packs, as a browser reads it."""

import json
import struct
import zlib

import numpy as np

from app.service.packing import FIELDS


def header(block):
    """What `pack` wrote in front of a block."""
    length = struct.unpack_from("<I", block)[0]
    return json.loads(block[4 : 4 + length])


def columns(block):
    """(header, {column: (n,)}) of a packed block."""
    head = header(block)
    n, count = head["frames"], len(head["columns"])
    changes = np.frombuffer(_body(block), "<i4", count=count * n).reshape(count, n)
    return head, dict(zip(head["columns"], np.cumsum(changes, axis=1, dtype="<i4").view("<f4"), strict=True))


def unpack(block):
    """(header, {column: (n,)}, {field: (k, m), int16 in steps, of the frames and nodes kept}) of a packed block."""
    head, curves = columns(block)
    (n, m), start = (len(head["kept"][of]) for of in ("frames", "nodes")), 4 * len(curves) * head["frames"]
    changes = np.frombuffer(_body(block), "<i2", offset=start).reshape(len(FIELDS), n, m)
    fields = np.cumsum(np.cumsum(changes, axis=2, dtype="<i2"), axis=1, dtype="<i2")
    return head, curves, dict(zip(head["scales"], fields, strict=True))


def _body(block):
    """What follows the header of a block."""
    return zlib.decompress(block[4 + struct.unpack_from("<I", block)[0] :])
