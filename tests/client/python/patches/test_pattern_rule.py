# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Patterns that the client makes by itself."""
import itertools

import latticed
import numpy as np
import pytest
from latticed.patches.pattern_rule import code_of, make_pattern


def test_every_pattern_fits_its_edges_and_covers_the_patch():
    most = 0
    for levels in itertools.product(range(6), repeat=3):
        pattern = make_pattern(int(code_of(levels)))

        points, whole = pattern.points, pattern.denominator
        for e, level in enumerate(levels):
            on_edge = points[points[:, (e + 2) % 3] == 0, (e + 1) % 3]
            np.testing.assert_array_equal(np.sort(on_edge) * 2**level, np.arange(2**level + 1) * whole)
        assert (points.sum(axis=1) == whole).all() and len(np.unique(points, axis=0)) == len(points)
        areas = np.linalg.det(points[pattern.triangles].astype(float)) / whole**3
        assert areas.min() > 0 and areas.sum() == pytest.approx(1)
        sides = np.sort(pattern.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        counts = np.unique(sides, axis=0, return_counts=True)[1]
        assert counts.max() <= 2 and (counts == 1).sum() == sum(2**level for level in levels)
        most = max(most, len(points))
    assert most == 1193


def test_equal_levels_are_the_uniform_pattern():
    for level in range(6):
        pattern = make_pattern(level * (1 + 8 + 64))
        segments = 2**level
        assert len(pattern) == (segments + 1) * (segments + 2) // 2 and pattern.denominator == segments
        assert len(pattern.triangles) == segments**2
    assert pattern.points[:3].tolist() == [[32, 0, 0], [31, 1, 0], [30, 2, 0]]
    assert pattern.points[33:35].tolist() == [[0, 31, 1], [1, 30, 1]], "odd rows run back"


@pytest.mark.parametrize("code", [6, 7 * 64, 512])
def test_other_codes_are_refused(code):
    with pytest.raises(ValueError, match=f"{code} is no code of the denser patterns"):
        make_pattern(code)


def test_patterns_are_those_of_the_server(scene, random):
    control_points = scene.lattice().control_points
    scene.replace(control_points + random.normal(scale=0.2, size=control_points.shape))
    seen = set()
    for tolerance in (0.1, 0.01, 0.001, 0.0001):
        view = latticed.View(tolerance=tolerance, segments=32, encoding="raw")
        for theirs in {id(p): p for p in scene.get_update(view, min_revision=1).patterns}.values():
            for code in range(512):
                if (code & 7) <= 5 and (code >> 3 & 7) <= 5 and code >> 6 <= 5:
                    ours = make_pattern(code)
                    same = len(ours) == len(theirs) and ours.denominator == theirs.denominator
                    if same and (ours.points == theirs.points).all():
                        np.testing.assert_array_equal(ours.triangles, theirs.triangles)
                        seen.add(code)
    assert len(seen) > 20
