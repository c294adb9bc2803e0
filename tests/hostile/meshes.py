# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Mesh files that are dear to read, and RAW grids."""
import math
import random
import struct

MOST_CORNERS = 65_536  # of a face


def ply_strip(indices):
    """One strip of so many bytes, each an index. A triangle, of 16 bytes at least, begins at each."""
    header = (
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nelement tristrips 1\nproperty list uint uchar vertex_indices\nend_header\n"
    )
    vertices = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
    body = (b"\0\1\2" * (indices // 3 + 1))[:indices]
    return header.encode() + vertices + struct.pack("<I", indices) + body


def dense_obj(megabytes):
    """Lines as short as they can be."""
    lines = b"v 0 0 0\n" * 50_000 + b"vt 0\n" * 50_000 + b"f 1 2 3\n" * 50_000 + b"f 1/1 2/2 3/3\n" * 20_000
    return b"v 1 0 0\nv 0 1 0\nv 0 0 1\n" + lines * max(1, int(megabytes * 1e6) // len(lines))


def varint(value):
    out = bytearray()
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    out.append(value)
    return bytes(out)


def draco(faces, extra_attributes):
    """A sequential Draco mesh with three points per face. Its indices, its positions and the 255 numbers that each
    extra attribute has per point are all zero: any number of zeros takes seven bytes. Zeros at the end make the file
    as long as its faces need: libdraco asks for three bytes of each."""
    # Raw symbols of one bit at most; a table of one symbol with the whole probability 4096; a state of one byte.
    zeros = bytes([1, 1, 1, 1, 64, 1, 0])
    header = b"DRACO" + bytes([2, 2, 1, 0]) + bytes(2)
    connectivity = varint(faces) + varint(3 * faces) + b"\0" + zeros
    # By attribute: kind (position, generic), float32, components, whether normalised, id. All are quantised.
    attributes = [bytes([0, 9, 3, 0, 0])] + [bytes([4, 9, 255, 0, 1 + n]) for n in range(extra_attributes)]
    announced = bytes([1, len(attributes)]) + b"".join(attributes) + bytes([2]) * len(attributes)
    values = (bytes([0xFE, 1]) + zeros) * len(attributes)
    grids = b"".join(bytes(4 * each[2]) + struct.pack("<fB", 1, 12) for each in attributes)
    return header + connectivity + announced + values + grids + bytes(3 * faces + 64)


def draco_tables(megabytes):
    """A sequential Draco mesh of one face whose indices have a table of probabilities for 64 symbols a byte, all zero:
    libdraco takes 12 bytes a symbol."""
    size = int(megabytes * 1e6)
    raw_of_18_bits = bytes([1, 18])
    connectivity = varint(1) + varint(3) + b"\0" + raw_of_18_bits + varint(64 * size) + b"\xff" * size
    return b"DRACO" + bytes([2, 2, 1, 0]) + bytes(2) + connectivity


def large_polygons(megabytes):
    """An OBJ file of star-shaped polygons with the most corners."""
    numbers = random.Random(1)
    lines = []
    for i in range(MOST_CORNERS):
        angle, radius = 2 * math.pi * i / MOST_CORNERS, numbers.uniform(0.5, 1)
        lines.append(f"v {radius * math.cos(angle):.5f} {radius * math.sin(angle):.5f} {i % 7 / 100}")
    vertices = ("\n".join(lines) + "\n").encode()
    face = ("f " + " ".join(map(str, range(1, MOST_CORNERS + 1))) + "\n").encode()
    return vertices + face * max(1, (int(megabytes * 1e6) - len(vertices)) // len(face))


def raw_grid(side, number=0):
    """A grid of side × side quads. Returns (its layout's vertices, faces, corners) and the bytes. `number` makes the
    bytes others."""
    import numpy

    y, x = numpy.mgrid[0 : side + 1, 0 : side + 1].astype("<f4")
    positions = numpy.stack([x, y, 0.01 * numpy.sin(x + number)], axis=-1).reshape(-1, 3)
    i = numpy.arange(side * (side + 1)).reshape(side, side + 1)[:, :-1].reshape(-1)
    quads = numpy.stack([i, i + 1, i + side + 2, i + side + 1], axis=-1).astype("<u4")
    return (len(positions), len(quads), quads.size), positions.tobytes() + quads.tobytes()
