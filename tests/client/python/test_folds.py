# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Folds: certified, reported with edits, refused. The box is 2 x 1 x 3 with a corner at the origin."""
import latticed
import numpy as np
import pytest

FOLDING = (9, 0, 0)  # takes an inner layer of control points far beyond the next one


@pytest.fixture
def watched(client, box):
    with client.create_scene(
        box, size=(4, 3, 5), degree=(3, 1, 2), fold_watch=True, delete_on_exit=True
    ) as made:
        yield made


def inner(scene):
    return scene.lattice().indices[:, :, 1]


def test_a_scene_at_rest_is_certified(scene):
    for volume in (False, True):
        report = scene.certify_folds(volume=volume)
        assert report.certified and report.places == ()
        assert report.boxes == 1 * 2 * 3
        assert report.revision == 0 and report.structure_id == 1


def test_a_fold_has_a_place(scene):
    scene.move(inner(scene), FOLDING)

    report = scene.certify_folds()

    assert not report.certified
    assert report.folded == sum(place.folded for place in report.places) > 0
    for place in report.places[:3]:
        jacobian = scene.evaluate([place.rest_point]).jacobians[0]
        assert np.linalg.det(jacobian) == pytest.approx(place.determinant, abs=1e-11)
        assert place.determinant <= 0
        assert all(0 <= n < most for n, most in zip(place.box, (1, 2, 3)))


def test_edits_of_a_watched_scene_have_a_report(watched):
    assert watched.move(inner(watched), (0.1, 0, 0)).folds.certified
    assert not watched.move(inner(watched), FOLDING).folds.certified
    assert watched.certify_folds().folded > 0
    result = watched.undo()
    assert result.folds.certified
    assert result.folds.revision == result.revision == 3


def test_edits_of_other_scenes_have_none(scene):
    assert scene.move(inner(scene), (0.1, 0, 0)).folds is None


def test_a_new_fold_is_refused(scene):
    scene.refuse_folds = True
    with pytest.raises(latticed.LatticedError) as refused:
        scene.move(inner(scene), FOLDING)
    assert refused.value.reason == "FOLD"
    assert float(refused.value.metadata["determinant"]) <= 0
    assert len(refused.value.metadata["rest_point"].split()) == 3

    change = latticed.edits.move(inner(scene), FOLDING)
    scene.apply([change], refuse_folds=False)
    scene.move(inner(scene), (0, 0.1, 0))  # an old fold may stay
    scene.undo("scene")


def test_a_gesture_stops_at_the_last_certified_state(scene):
    scene.refuse_folds = True
    with scene.gesture() as drag:
        drag.move(inner(scene), (0.1, 0, 0))
        with pytest.raises(latticed.LatticedError, match="makes a fold"):
            drag.move(inner(scene), FOLDING)
    moved = scene.lattice()
    assert scene.certify_folds(volume=True).certified
    scene.undo()
    assert np.abs(moved.control_points - scene.lattice().control_points).max() == pytest.approx(0.1)


def test_a_stream_refuses_folds_too(watched):
    with watched.deform() as stream:
        stream.refuse_folds = True
        first = stream.move(inner(watched), (0.1, 0, 0))
        second = stream.move(inner(watched), FOLDING)
        stream.wait(first)
        assert stream.result(first).folds.certified
        with pytest.raises(latticed.LatticedError, match="makes a fold"):
            stream.wait(second)
