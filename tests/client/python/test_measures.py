# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Measures of the surface, and constraints. The box is 2 x 1 x 3 with a corner at the origin."""
import numpy as np
import pytest

import latticed


def test_measures_of_the_box(scene):
    got = scene.measure("volume", "area", "centroid", "bounds")

    assert got.revision == 0 and got.structure_id == 1
    assert got.volume == pytest.approx(6, rel=1e-12)
    assert got.area == pytest.approx(2 * (2 + 3 + 6), rel=1e-6)
    np.testing.assert_allclose(got.centroid, [1, 0.5, 1.5], atol=1e-12)
    np.testing.assert_allclose(got.bounds, [[0, 0, 0], [2, 1, 3]], atol=1e-8)
    assert got.volume_gradient is None and scene.measure("area").volume is None


def test_gradients_predict_a_move(scene):
    point = int(scene.lattice().indices[-1, 0, 0])
    before = scene.measure("volume", "area", "centroid", with_gradient=True, area_tolerance=1e-10)
    scene.move([point], (0, 0, 1e-5))
    after = scene.measure("volume", "area", "centroid", area_tolerance=1e-10)

    assert (after.volume - before.volume) / 1e-5 == pytest.approx(before.volume_gradient[point, 2], abs=1e-4)
    assert (after.area - before.area) / 1e-5 == pytest.approx(before.area_gradient[point, 2], abs=1e-3)
    slope = (after.centroid - before.centroid) / 1e-5
    np.testing.assert_allclose(slope, before.centroid_gradient[point, 2], atol=1e-4)


def test_a_kept_volume(scene):
    kept = latticed.Constraints(
        held=(0,), held_layers={"w-": 1}, mirror="u", keep_volume=True, volume_axis="w"
    )
    scene.set_constraints(kept)
    assert scene.constraints() == kept
    before = scene.lattice()

    scene.move(before.indices[-1, 0, 0], (0.3, 0.2, 0.5))

    assert scene.measure("volume").volume == pytest.approx(6, rel=1e-12)
    np.testing.assert_array_equal(scene.lattice().control_points[0], before.control_points[0])
    scene.set_constraints(latticed.Constraints())
    assert scene.constraints() == latticed.Constraints()
    with scene.gesture(keep_volume=True) as pull:
        pull.move(before.indices[-1, 0, 0], (0.3, 0.2, 0.5))
    assert scene.measure("volume").volume == pytest.approx(6, rel=1e-12)


def test_bad_values_are_refused(scene):
    with pytest.raises(ValueError, match="a measure is one of volume"):
        scene.measure("weight")
    with pytest.raises(ValueError, match="a face is an axis"):
        scene.set_constraints(latticed.Constraints(held_layers={"u": 1}))
    with pytest.raises(latticed.LatticedError, match="at least one"):
        scene.measure()
