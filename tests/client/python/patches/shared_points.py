# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Points that patches share, compared bit by bit."""
import numpy as np

WHOLE = 4096


def shared_points(plan, surface, torn=False):
    """Groups points by the vertex or edge of the plan that they lie on: by the pair of vertices, and the whole numbers
    along the edge. Those of patches inside and outside the frame are groups apart if they are torn.

    Returns the number of groups with several points, how many of them lie in several boxes, and how many have points
    of different bits."""
    patch = np.repeat(np.arange(len(plan)), np.diff(surface.first_points))
    whole = np.concatenate([p.points * (WHOLE // p.denominator) for p in surface.patterns])
    on_border = (whole == 0).any(axis=1)
    patch, whole, points = patch[on_border], whole[on_border], surface.relative_points[on_border]
    # The two corners of largest weight, by vertex; the third weight is 0.
    order = np.argsort(-whole, axis=1, kind="stable")[:, :2]
    vertices = np.take_along_axis(plan.corners[patch], order, axis=1)
    weights = np.take_along_axis(whole, order, axis=1)
    vertices = np.where(weights == 0, -1, vertices)
    by_vertex = np.argsort(vertices, axis=1)
    side = np.where(torn & (patch >= plan.inside), 1, 0)
    keys = np.column_stack(
        [
            np.take_along_axis(vertices, by_vertex, axis=1),
            np.take_along_axis(weights, by_vertex, axis=1),
            side,
        ]
    )
    boxes = np.column_stack([plan.spans[patch], patch >= plan.inside])
    groups, counts = np.unique(keys, axis=0, return_inverse=True, return_counts=True)[1:]

    def distinct(values):
        return np.bincount(np.unique(np.column_stack([groups, values]), axis=0)[:, 0].astype(np.int64))

    bits = np.ascontiguousarray(points).view(f"u{points.itemsize}").astype(np.uint64).astype(np.int64)
    return (counts > 1).sum(), (distinct(boxes) > 1).sum(), (distinct(bits) > 1).sum()
