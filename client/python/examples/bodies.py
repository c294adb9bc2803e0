# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Meshes and functionals of the optimisation examples."""
import numpy as np


def sphere(rings=24, sides=48):
    """Vertices and triangles of a unit sphere, oriented outwards."""
    polar = np.pi * (np.arange(1, rings)) / rings
    around = 2 * np.pi * np.arange(sides) / sides
    p, a = np.meshgrid(polar, around, indexing="ij")
    middle = np.stack([np.cos(p), np.sin(p) * np.cos(a), np.sin(p) * np.sin(a)], axis=-1).reshape(-1, 3)
    vertices = np.concatenate([[[1, 0, 0]], middle, [[-1, 0, 0]]])
    at = 1 + np.arange((rings - 1) * sides).reshape(rings - 1, sides)
    right = np.roll(at, -1, axis=1)
    first, last = np.full(sides, 0), np.full(sides, len(vertices) - 1)
    triangles = np.concatenate(
        [
            np.stack([first, at[0], right[0]], axis=-1),
            np.stack([at[:-1], at[1:], right[1:]], axis=-1).reshape(-1, 3),
            np.stack([at[:-1], right[1:], right[:-1]], axis=-1).reshape(-1, 3),
            np.stack([at[-1], last, right[-1]], axis=-1),
        ]
    )
    return vertices, triangles


def scatter(triangles, by_corner, count):
    """Sums of what the corners of triangles, (m, 3, 3), give to each vertex, (count, 3)."""
    return np.stack(
        [np.bincount(triangles.ravel(), by_corner[..., c].ravel(), count) for c in range(3)], axis=-1
    )


def volume(triangles):
    """The volume that a closed triangle mesh encloses, as a function of its vertices, with its derivative."""

    def function(x):
        a, b, c = (x[triangles[:, k]] for k in range(3))
        value = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
        by_corner = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1) / 6
        return value, scatter(triangles, by_corner, len(x))

    return function


def impact_drag(triangles, flow):
    """Newton's drag: the pressure on a face that the flow meets at an angle t from its normal is cos^2 t.

    Sum over the faces met of area (cos t)^3 = (s . flow)^3 / |s|^2, s the face's area vector, outwards.
    """
    flow = np.asarray(flow, dtype=float)

    def function(x):
        a, b, c = (x[triangles[:, k]] for k in range(3))
        s = np.cross(b - a, c - a) / 2
        met = np.maximum(-s @ flow, 0)
        size2 = np.maximum(np.einsum("ij,ij->i", s, s), 1e-30)
        value = float((met**3 / size2).sum())
        by_s = -3 * (met**2 / size2)[:, None] * flow - 2 * (met**3 / size2**2)[:, None] * s
        # s = (b - a) x (c - a) / 2
        by_b, by_c = np.cross(c - a, by_s) / 2, np.cross(by_s, b - a) / 2
        return value, scatter(triangles, np.stack([-by_b - by_c, by_b, by_c], axis=1), len(x))

    return function


def plot_convergence(path, curves, title):
    """Draws curves, a dictionary from labels to numbers, over the iterations."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(6, 4))
    for label, numbers in curves.items():
        axes.semilogy(np.maximum(numbers, 1e-16), label=label)
    axes.set_xlabel("iteration")
    axes.set_title(title)
    axes.grid(True, which="both", alpha=0.3)
    axes.legend()
    figure.savefig(path, dpi=100, bbox_inches="tight")
    pyplot.close(figure)
