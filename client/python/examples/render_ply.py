#!/usr/bin/env python3
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: render_ply.py OUT.png A.ply [B.ply …]
# Renders binary PLY meshes (float x y z nx ny nz …, uchar int triangles) side by side at one scale. It draws
# surface samples into a z-buffer with four entries per pixel, shaded by normal. It needs only numpy.
import re
import struct
import sys
import zlib

import numpy

HEIGHT = 520
SUPERSAMPLING = 2
BACKGROUND = 250
VIEW = (-62.0, 28.0)  # turn about z, then tilt, in degrees
LIGHT = numpy.array([-0.45, -0.35, 0.82])


def read_ply(path):
    data = open(path, "rb").read()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    header = data[:end].decode("ascii")
    assert "binary_little_endian" in header, path
    vertices = int(re.search(r"element vertex (\d+)", header)[1])
    faces = int(re.search(r"element face (\d+)", header)[1])
    properties = re.findall(r"property float (\w+)", header)
    table = numpy.frombuffer(data, "<f4", vertices * len(properties), end).reshape(vertices, -1)
    face_type = numpy.dtype([("count", "u1"), ("corners", "<i4", 3)])
    triangles = numpy.frombuffer(data, face_type, faces, end + table.nbytes)
    assert (triangles["count"] == 3).all(), path
    return table[:, :3].astype(float), table[:, 3:6].astype(float), triangles["corners"]


def rotation():
    turn, tilt = numpy.radians(VIEW)
    z = numpy.array(
        [[numpy.cos(turn), -numpy.sin(turn), 0], [numpy.sin(turn), numpy.cos(turn), 0], [0, 0, 1]]
    )
    x = numpy.array(
        [[1, 0, 0], [0, numpy.cos(tilt), -numpy.sin(tilt)], [0, numpy.sin(tilt), numpy.cos(tilt)]]
    )
    # World z is up: the screen's y is -z, and the depth is y.
    return numpy.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]) @ x @ z


def samples(corners, normals):
    """Yields points of all triangles, at most about a pixel apart, and their normals."""
    edges = numpy.linalg.norm(corners[:, :, :2] - numpy.roll(corners, 1, axis=1)[:, :, :2], axis=2).max(
        axis=1
    )
    steps = numpy.clip(numpy.ceil(edges / 0.7), 1, 400).astype(int)
    for n in numpy.unique(steps):
        chosen = steps == n
        for i in range(n + 1):
            for j in range(n + 1 - i):
                weights = numpy.array([i, j, n - i - j]) / n
                yield (
                    numpy.einsum("k,tkc->tc", weights, corners[chosen]),
                    numpy.einsum("k,tkc->tc", weights, normals[chosen]),
                )


def render(mesh, scale, width, height):
    positions, normals, triangles = mesh
    turn = rotation()
    screen = (positions - (positions.min(axis=0) + positions.max(axis=0)) / 2) @ turn.T * scale
    screen[:, :2] -= (screen[:, :2].min(axis=0) + screen[:, :2].max(axis=0)) / 2 - numpy.array(
        [width, height]
    ) / 2
    depth, shade = numpy.full(width * height, numpy.inf), numpy.full(width * height, float(BACKGROUND))
    light = LIGHT / numpy.linalg.norm(LIGHT)
    for points, directions in samples(screen[triangles], normals[triangles]):
        x, y = numpy.floor(points[:, 0]).astype(int), numpy.floor(points[:, 1]).astype(int)
        inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
        pixel, z = (y * width + x)[inside], points[inside, 2]
        order = numpy.argsort(-z)  # the nearest sample of a pixel is written last
        pixel, z, n = pixel[order], z[order], directions[inside][order]
        n /= numpy.maximum(numpy.linalg.norm(n, axis=1, keepdims=True), 1e-12)
        view = n @ turn.T
        n = numpy.where(view[:, 2:3] > 0, -n, n)  # both sides are lit
        value = 45 + 170 * (0.5 + 0.5 * n @ light) ** 1.6 + 25 * numpy.clip(n @ light, 0, 1) ** 30
        nearer = z < depth[pixel]
        depth[pixel[nearer]], shade[pixel[nearer]] = z[nearer], value[nearer]
    return shade.reshape(height, width)


def write_png(path, grey):
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    height, width = grey.shape
    levels = numpy.arange(256)
    palette = numpy.stack([levels * 0.86, levels * 0.94, levels * 1.0], axis=1)
    palette[BACKGROUND] = 255
    up = grey.copy()
    up[1:] -= grey[:-1]  # PNG filter 2 stores differences, which are small for smooth shading
    rows = numpy.concatenate([numpy.full((height, 1), 2, numpy.uint8), up], axis=1)
    with open(path, "wb") as file:
        file.write(
            b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 3, 0, 0, 0))
        )
        file.write(chunk(b"PLTE", palette.astype(numpy.uint8).tobytes()))
        file.write(chunk(b"IDAT", zlib.compress(rows.tobytes(), 9)) + chunk(b"IEND", b""))


def picture(out, meshes, height=HEIGHT):
    """Draws meshes, each (positions, normals, triangles), side by side, `height` pixels high."""
    boxes = [numpy.ptp(m[0] @ rotation().T, axis=0) for m in meshes]
    height *= SUPERSAMPLING
    scale = 0.92 * height / max(box[1] for box in boxes)
    panels = [render(m, scale, int(box[0] * scale + 0.12 * height), height) for m, box in zip(meshes, boxes)]
    picture = numpy.concatenate(panels, axis=1)
    rows, columns = (n // SUPERSAMPLING * SUPERSAMPLING for n in picture.shape)
    small = (
        picture[:rows, :columns]
        .reshape(rows // SUPERSAMPLING, SUPERSAMPLING, -1, SUPERSAMPLING)
        .mean(axis=(1, 3))
    )
    write_png(out, small.round().astype(numpy.uint8))


def main(out, *paths):
    picture(out, [read_ply(path) for path in paths])


if __name__ == "__main__":
    main(*sys.argv[1:])
