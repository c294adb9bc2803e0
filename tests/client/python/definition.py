# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The deformation computed from its definition, in double precision, and a small mesh."""
import numpy as np

# A box of 2 x 1 x 3 units whose faces are quads.
BOX_POSITIONS = np.array(
    [[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0], [0, 0, 3], [2, 0, 3], [2, 1, 3], [0, 1, 3]], dtype=float
)
BOX_FACES = np.array([[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]])
BOX_AREA = 2 * (2 * 1 + 2 * 3 + 1 * 3)


def basis(knots, degree, parameters):
    """(n, functions): the values of all B-spline basis functions at n parameters of the domain, by the Cox-de Boor
    recursion."""
    count = len(knots) - degree - 1
    spans = np.minimum(np.searchsorted(knots, parameters, side="right") - 1, count - 1)
    values = np.zeros((len(knots) - 1, len(parameters)))
    values[spans, np.arange(len(parameters))] = 1.0
    for p in range(1, degree + 1):
        for i in range(len(knots) - 1 - p):
            left = right = 0.0
            if knots[i + p] > knots[i]:
                left = (parameters - knots[i]) / (knots[i + p] - knots[i]) * values[i]
            if knots[i + p + 1] > knots[i + 1]:
                right = (knots[i + p + 1] - parameters) / (knots[i + p + 1] - knots[i + 1]) * values[i + 1]
            values[i] = left + right
    return values[:count].T


def deform(lattice, points):
    """R(u, v, w), the deformed position, of every point. Points must lie inside the lattice's frame."""
    return deform_shares(lattice, (np.asarray(points) - lattice.origin) @ np.linalg.inv(lattice.edges))


def deform_shares(lattice, shares):
    """The same of points by their place in the frame, 0 to 1 along each of its edges."""
    shares = np.asarray(shares)
    u, v, w = (
        basis(knots, degree, knots[degree] + share * (knots[len(knots) - degree - 1] - knots[degree]))
        for knots, degree, share in zip(lattice.knots, lattice.degree, shares.T)
    )
    by_w_v = np.einsum("kjix,ni->nkjx", lattice.control_points, u)
    return np.einsum("nkx,nk->nx", np.einsum("nkjx,nj->nkx", by_w_v, v), w)


def area(update):
    """The total area of an update's triangles."""
    a, b, c = update.points.reshape(-1, 3)[update.triangles].transpose(1, 0, 2)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
