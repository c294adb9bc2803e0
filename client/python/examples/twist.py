#!/usr/bin/env python3
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: twist.py OUT.png [--server ADDRESS] [--height PIXELS]
# Makes a picture from arrays: makes a torus knot with numpy, twists its lattice in two steps, and renders the
# update before and after each step from its points, normals and triangles.
import argparse

import latticed
import numpy as np
import render_ply

SIDES, RINGS = 24, 240


def knot():
    """Vertices and quads of a tube around a (2, 3) torus knot."""
    t = np.linspace(0, 2 * np.pi, RINGS, endpoint=False)

    def centre(t):
        radius = 2 + np.cos(3 * t)
        return np.stack([radius * np.cos(2 * t), radius * np.sin(2 * t), 1.4 * np.sin(3 * t)], axis=-1)

    tangent = centre(t + 1e-4) - centre(t - 1e-4)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    across = np.cross(tangent, [0, 0, 1])
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    angle = np.linspace(0, 2 * np.pi, SIDES, endpoint=False)[:, None]
    circles = [np.cos(angle) * a + np.sin(angle) * np.cross(a, d) for a, d in zip(across, tangent)]
    ring, side = np.meshgrid(np.arange(RINGS), np.arange(SIDES), indexing="ij")
    next_ring, next_side = (ring + 1) % RINGS, (side + 1) % SIDES
    quads = np.stack(
        [
            ring * SIDES + side,
            ring * SIDES + next_side,
            next_ring * SIDES + next_side,
            next_ring * SIDES + side,
        ],
        axis=-1,
    )
    return (centre(t)[:, None] + 0.45 * np.array(circles)).reshape(-1, 3), quads.reshape(-1, 4)


def twisted(lattice, angle):
    """Control points turned about the vertical axis in proportion to their height, and stretched along it."""
    points = lattice.rest()
    turn = angle * np.linspace(-1, 1, lattice.size[2])[:, None, None]
    c, s = np.cos(turn), np.sin(turn)
    x, y, z = points[..., 0], points[..., 1], points[..., 2]
    return np.stack([c * x - s * y, s * x + c * y, z * (1 + 0.4 * abs(angle))], axis=-1)


def main(arguments):
    with latticed.connect(arguments.server) as client:
        mesh = client.upload_arrays(*knot(), name="knot")
        view = latticed.View(segments=3, normals="smooth")
        with client.create_scene(mesh, size=(5, 5, 6), delete_on_exit=True) as scene, scene.deform(
            view
        ) as stream:
            updates = [stream.latest]
            for angle in (0.6, 1.2):
                updates.append(stream.wait(stream.replace(twisted(stream.lattice, angle))))
    meshes = [(u.points.reshape(-1, 3), u.normals.reshape(-1, 3).astype(float), u.triangles) for u in updates]
    with open(arguments.out, "wb") as file:
        file.write(render_ply.picture(meshes, arguments.height))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("out")
    parser.add_argument("--server")
    parser.add_argument("--height", type=int, default=render_ply.HEIGHT)
    main(parser.parse_args())
