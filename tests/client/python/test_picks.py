# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Picks on the surface, and drags of picked points. The box is 2 x 1 x 3 with a corner at the origin."""
import numpy as np
import pytest


def test_a_pick_is_a_point_of_the_surface(scene):
    scene.move(scene.lattice().indices[-1], (0.1, 0.2, 0.5))

    point = scene.pick((0.7, 0.4, 9), (0, 0, -1))

    assert point is not None
    there = scene.evaluate_surface([point.face], [point.corners], [point.barycentrics])
    np.testing.assert_allclose(point.position, there.positions[0], atol=1e-12)
    np.testing.assert_allclose(point.normal, there.normals[0], atol=1e-9)
    np.testing.assert_allclose(point.position[:2], [0.7, 0.4], atol=1e-9)
    assert scene.pick((0.7, 0.4, 9), (0, 0, 1)) is None


def test_drags_take_picked_points_to_their_targets(scene):
    top = scene.pick((0.7, 0.4, 9), (0, 0, -1))
    side = scene.pick((9, 0.5, 1.5), (-1, 0, 0))
    targets = [top.position + [0, 0, 1], side.position + [0.5, 0.25, 0]]

    result = scene.drag([top, side], targets)

    there = scene.evaluate_surface(
        [top.face, side.face], [top.corners, side.corners], [top.barycentrics, side.barycentrics]
    )
    np.testing.assert_allclose(there.positions, targets, atol=1e-12)
    assert result.drag_residual < 1e-12
    assert scene.drag([top, top], [[0, 0, 0], [0, 0, 2]]).drag_residual == pytest.approx(1)
    with pytest.raises(ValueError, match="2 points need as many targets"):
        scene.drag([top, side], targets[:1])
