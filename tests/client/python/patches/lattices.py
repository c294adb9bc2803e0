# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Lattices with moved control points, uneven knots and a slanted frame."""
import latticed
import numpy as np


def moved_lattice(random, degree, knots=None, left_handed=False, move=0.4, spans=(3, 2, 4)):
    """A lattice whose control points are moved by up to `move` of their mean distances on each axis.

    knots  of each axis; None: clamped, with these numbers of spans of uneven widths"""
    if knots is None:
        inner = [np.cumsum(random.uniform(0.5, 2, size=count)) for count in spans]
        knots = [np.concatenate([[0] * (p + 1), axis, [axis[-1]] * p]) for p, axis in zip(degree, inner)]
    edges = np.array([[3.0, 0.2, 0], [0.1, 2, 0.4], [-0.3, 0, 2.5]])
    if left_handed:
        edges[1] *= -1
    size = [len(axis) - p - 1 for axis, p in zip(knots, degree)]
    lattice = latticed.Lattice(
        np.zeros((*size[::-1], 3)), tuple(degree), tuple(knots), np.array([10.0, -4, 7]), edges
    )
    lattice.control_points = lattice.rest()
    spacing = edges / np.array(size)[:, None]
    lattice.control_points += random.uniform(-move, move, size=(*size[::-1], 3)) @ spacing
    return lattice
