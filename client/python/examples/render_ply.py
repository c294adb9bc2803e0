#!/usr/bin/env python3
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: render_ply.py [--edges] OUT.png A.ply [B.ply …]
# Renders binary PLY meshes (float properties, faces of uchar int) side by side at one scale. It draws surface
# samples into a z-buffer with four entries per pixel, shaded by normal. A mesh without normals is shaded flat. With
# --edges it draws the edges of triangles as well. It needs only numpy. On a terminal it shows its progress.
import argparse
import re
import struct
import sys
import zlib

import numpy

HEIGHT = 520
SUPERSAMPLING = 2
BACKGROUND = 250
SPACING = 0.7  # of samples along a triangle's longest edge, in z-buffer entries
MOST_STEPS = 2000  # samples along an edge
EDGE_WIDTH = 0.8  # to both sides, in z-buffer entries
EDGE_SHADE = 0.35  # of the surface's
BLOCK = 1 << 16  # samples computed at once: their arrays stay in the cache
VIEW = (-62.0, 28.0)  # turn about z, then tilt, in degrees
LIGHT = numpy.array([-0.45, -0.35, 0.82])


def read_ply(path):
    with open(path, "rb") as file:
        data = file.read()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    header = data[:end].decode("ascii")
    assert "binary_little_endian" in header, path
    vertices = int(re.search(r"element vertex (\d+)", header)[1])
    faces = int(re.search(r"element face (\d+)", header)[1])
    properties = re.findall(r"property float (\w+)", header)
    table = numpy.frombuffer(data, "<f4", vertices * len(properties), end).reshape(vertices, -1)
    points, corners = table[:, :3].astype(float), read_triangles(data[end + table.nbytes :], faces)
    if "nx" not in properties:
        return flat(points, corners)
    first = properties.index("nx")
    return points, table[:, first : first + 3].astype(float), corners


def read_triangles(data, faces):
    """The corners of all faces; a polygon becomes a fan of triangles."""
    face_type = numpy.dtype([("count", "u1"), ("corners", "<i4", 3)])
    if len(data) == faces * face_type.itemsize:
        triangles = numpy.frombuffer(data, face_type, faces)
        if (triangles["count"] == 3).all():
            return triangles["corners"]
    fans, at = [], 0
    for _ in range(faces):
        count = data[at]
        corners = struct.unpack_from(f"<{count}i", data, at + 1)
        fans += [(corners[0], corners[i], corners[i + 1]) for i in range(1, count - 1)]
        at += 1 + 4 * count
    return numpy.array(fans)


def flat(points, triangles):
    """The mesh with corners of its own for each triangle, which have the triangle's normal."""
    corners = points[triangles]
    normals = numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= numpy.maximum(numpy.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    places = numpy.arange(3 * len(triangles)).reshape(-1, 3)
    return corners.reshape(-1, 3), numpy.repeat(normals, 3, axis=0), places


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


def blocks(corners):
    """Yields (triangles, weights): sample each of these triangles at all of these barycentrics.

    corners   (triangles, 3, 3): x, y, depth, in z-buffer entries
    triangles (t,), weights (k, 3), t k at most BLOCK unless t = 1. An edge has n + 1 samples at most SPACING
              apart, and a triangle k = (n+1)(n+2)/2. Near triangles come first: they hide others.
    """
    edges = numpy.linalg.norm((corners - numpy.roll(corners, 1, axis=1))[:, :, :2], axis=2).max(axis=1)
    steps = numpy.clip(numpy.ceil(edges / SPACING), 1, MOST_STEPS).astype(int)
    by_depth = numpy.argsort(corners[:, 0, 2])
    for n in numpy.unique(steps):
        i, j = numpy.indices((n + 1, n + 1)).reshape(2, -1)
        weights = numpy.stack([i, j, n - i - j], axis=1)[i + j <= n] / n
        alike = by_depth[steps[by_depth] == n]
        at_once = max(1, BLOCK // len(weights))
        for begin in range(0, len(alike), at_once):
            yield alike[begin : begin + at_once], weights


def nearest(corners, width, height, progress):
    """Finds the nearest sample of every entry of the z-buffer that shows the mesh.

    Returns the entries (m,), row by row, and each one's triangle (m,) and barycentrics (m, 3).
    """
    depth = numpy.full(width * height, numpy.inf)
    owner, place = numpy.zeros(width * height, int), numpy.zeros((width * height, 3))
    done = 0
    for triangles, weights in blocks(corners):
        x, y, z = ((weights @ corners[triangles, :, axis].T).ravel() for axis in range(3))
        entry = y.astype(int) * width + x.astype(int)  # picture leaves a margin: no sample is outside
        near = numpy.flatnonzero(z < depth[entry])
        entry, z = entry[near], z[near]
        left = numpy.arange(len(near))
        while len(left):  # samples of one entry overwrite each other in any order, so repeat the nearer ones
            depth[entry[left]] = z[left]
            left = left[z[left] < depth[entry[left]]]
        first = z == depth[entry]
        weight, triangle = numpy.divmod(near[first], len(triangles))
        owner[entry[first]], place[entry[first]] = triangles[triangle], weights[weight]
        done += len(triangles)
        progress(done / len(corners))
    shown = numpy.flatnonzero(depth < numpy.inf)
    return shown, owner[shown], place[shown]


def near_edge(corners, weights):
    """Whether points, by their barycentrics (m, 3) in triangles (m, 3, 3) on the screen, are close to an edge."""
    sides = numpy.roll(corners, 1, axis=1) - numpy.roll(corners, -1, axis=1)  # side k is opposite corner k
    area = numpy.abs(sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0])
    lengths = numpy.maximum(numpy.hypot(sides[:, :, 0], sides[:, :, 1]), 1e-12)
    return (weights * area[:, None] / lengths).min(axis=1) < EDGE_WIDTH


def render(mesh, scale, width, height, edges, progress):
    """Grey levels (height, width) of a mesh at `scale` z-buffer entries per world unit."""
    positions, normals, triangles = mesh
    turn = rotation()
    screen = (positions - (positions.min(axis=0) + positions.max(axis=0)) / 2) @ turn.T * scale
    screen[:, :2] -= (screen[:, :2].min(axis=0) + screen[:, :2].max(axis=0)) / 2 - numpy.array(
        [width, height]
    ) / 2
    entries, owner, weights = nearest(screen[triangles], width, height, progress)
    n = numpy.einsum("mk,mkc->mc", weights, normals[triangles[owner]])
    n /= numpy.maximum(numpy.linalg.norm(n, axis=1, keepdims=True), 1e-12)
    n = numpy.where(n @ turn.T[:, 2:] > 0, -n, n)  # both sides are lit
    lit = n @ (LIGHT / numpy.linalg.norm(LIGHT))
    shade = numpy.full(width * height, float(BACKGROUND))
    shade[entries] = 45 + 170 * (0.5 + 0.5 * lit) ** 1.6 + 25 * numpy.clip(lit, 0, 1) ** 30
    if edges:
        shade[entries[near_edge(screen[triangles[owner]], weights)]] *= EDGE_SHADE
    return shade.reshape(height, width)


def png(grey):
    """The bytes of a PNG file, of grey levels (height, width) as uint8."""

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    height, width = grey.shape
    levels = numpy.arange(256)
    palette = numpy.stack([levels * 0.86, levels * 0.94, levels * 1.0], axis=1)
    palette[BACKGROUND] = 255
    up = grey.copy()
    up[1:] -= grey[:-1]  # PNG filter 2 stores differences, which are small for smooth shading
    rows = numpy.concatenate([numpy.full((height, 1), 2, numpy.uint8), up], axis=1)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 3, 0, 0, 0))
        + chunk(b"PLTE", palette.astype(numpy.uint8).tobytes())
        + chunk(b"IDAT", zlib.compress(rows.tobytes(), 9))
        + chunk(b"IEND", b"")
    )


def terminal_progress(label):
    """A function of the share done, 0 to 1. It writes a line on standard error if that is a terminal."""
    if sys.stderr is None or not sys.stderr.isatty():
        return lambda share: None

    def show(share):
        print(f"\r{label} {share:4.0%}", end="\n" if share >= 1 else "", file=sys.stderr, flush=True)

    return show


def picture(meshes, height=HEIGHT, edges=False):
    """Draws meshes, each (positions, normals, triangles), side by side. Returns a PNG, `height` pixels high."""
    boxes = [numpy.ptp(m[0] @ rotation().T, axis=0) for m in meshes]
    height *= SUPERSAMPLING
    scale = 0.92 * height / max(box[1] for box in boxes)
    panels = []
    for number, (mesh, box) in enumerate(zip(meshes, boxes), 1):
        progress = terminal_progress(f"draw mesh {number} of {len(meshes)}")
        panels.append(render(mesh, scale, int(box[0] * scale + 0.12 * height), height, edges, progress))
    drawn = numpy.concatenate(panels, axis=1)
    rows, columns = (n // SUPERSAMPLING * SUPERSAMPLING for n in drawn.shape)
    small = (
        drawn[:rows, :columns]
        .reshape(rows // SUPERSAMPLING, SUPERSAMPLING, -1, SUPERSAMPLING)
        .mean(axis=(1, 3))
    )
    return png(small.round().astype(numpy.uint8))


def main():
    parser = argparse.ArgumentParser(description="Renders binary PLY meshes side by side.")
    parser.add_argument("--edges", action="store_true", help="draw the edges of triangles")
    parser.add_argument("out", metavar="OUT.png")
    parser.add_argument("meshes", metavar="A.ply", nargs="+")
    arguments = parser.parse_args()
    drawn = picture([read_ply(path) for path in arguments.meshes], edges=arguments.edges)
    with open(arguments.out, "wb") as file:
        file.write(drawn)


if __name__ == "__main__":
    main()
