#!/usr/bin/env python3
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: tetrahedra.py [IN.vtu] [--out OUT.vtu] [--nodes N] [--server ADDRESS]
# Deforms the nodes of a volume mesh as a point set, and reports the least volume of its cells. Without a file the mesh is a
# block of N x N x N nodes, 100 unless given: a million nodes in 5.8 million tetrahedra around a ball. Files are read and
# written by the package meshio: VTU, VTK, Gmsh, SU2, and others.
import argparse
import time

import bodies
import latticed
import numpy as np


def block(n):
    """Nodes and tetrahedra of a cube [-2, 2]^3: six in each of (n - 1)^3 cells, round the same diagonal (Kuhn)."""
    axis = np.linspace(-2, 2, n)
    nodes = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(n**3).reshape(n, n, n)

    def corner(*at):
        return number[tuple(slice(a, n - 1 + a) for a in at)].ravel()

    cells = []
    for order in [(0, 1, 2), (1, 2, 0), (2, 0, 1), (1, 0, 2), (0, 2, 1), (2, 1, 0)]:
        at, path = np.zeros(3, dtype=int), []
        for step in [None, *order]:
            if step is not None:
                at[step] = 1
            path.append(corner(*at))
        if order in [(1, 0, 2), (0, 2, 1), (2, 1, 0)]:  # odd permutations turn the other way round
            path[2], path[3] = path[3], path[2]
        cells.append(np.stack(path, axis=-1))
    return nodes, np.concatenate(cells)


def volumes(nodes, cells, part=1 << 20):
    """Signed volumes of tetrahedra."""
    found = np.empty(len(cells))
    for begin in range(0, len(cells), part):
        a, b, c, d = (nodes[cells[begin : begin + part, k]] for k in range(4))
        found[begin : begin + part] = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6
    return found


def main(arguments):
    if arguments.mesh:
        import meshio

        read = meshio.read(arguments.mesh)
        nodes, cells = read.points, read.cells_dict["tetra"]
    else:
        nodes, cells = block(arguments.nodes)
    centre, size = (nodes.max(axis=0) + nodes.min(axis=0)) / 2, np.ptp(nodes, axis=0)
    vertices, triangles = bodies.sphere(12, 24)
    with latticed.connect(arguments.server) as client:
        mesh = client.upload_arrays(centre + 0.25 * size * vertices, triangles, name="ball", progress=False)
        lattice = {"size": (6, 6, 6), "degree": (2, 2, 2)}
        with client.create_scene(mesh, delete_on_exit=True, **lattice) as scene, scene.points(
            nodes
        ) as points:
            control_points = scene.lattice().control_points
            inner = control_points[2:-2, 2:-2, 2:-2]  # two layers stay, so the block is smooth at the frame
            inner += 0.08 * size * np.array([1.0, 0.5, -0.25])
            scene.replace(control_points)
            begin = time.perf_counter()
            deformed = points.deform().positions
            seconds = time.perf_counter() - begin
    before, after = volumes(nodes, cells), volumes(deformed, cells)
    moved = np.linalg.norm(deformed - nodes, axis=1).max()
    print(
        f"{len(nodes)} nodes, {len(cells)} tetrahedra; nodes move by up to {moved:.3g}, {seconds:.2f} s with transport"
    )
    print(f"least volume of a cell: {before.min():.4g} at rest, {after.min():.4g} deformed")
    print(
        f"least volume of a cell / the same cell at rest: {(after / before).min():.3f}; inverted: {(after <= 0).sum()}"
    )
    if arguments.out:
        import meshio

        meshio.Mesh(deformed, [("tetra", cells)]).write(arguments.out)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("mesh", nargs="?")
    parser.add_argument("--out")
    parser.add_argument("--nodes", type=int, default=100)
    parser.add_argument("--server", default=None)
    main(parser.parse_args())
