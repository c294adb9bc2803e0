# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Views of patches of a real server: what PatchEvaluator makes of them, against EvaluatePoints and against points that
the server evaluates."""
import latticed
import numpy as np
import pytest

from shared_points import shared_points

PATCHES = latticed.View(encoding="patches")
LEVEL = 2  # of all edges, and 4 segments: the same points in the same order
UNIFORM = dict(segments=4, encoding="raw")


def moved_scene(client, mesh, random, degree=(2, 2, 2), **options):
    """A scene whose control points are moved by up to 0.4 of their mean distances."""
    size = {(1, 1, 1): (4, 5, 3), (2, 2, 2): (6, 4, 5), (3, 3, 3): (5, 6, 4), (3, 1, 2): (4, 3, 5)}[degree]
    scene = client.create_scene(mesh, size=size, degree=degree, delete_on_exit=True, **options)
    lattice = scene.lattice()
    spacing = lattice.edges / np.array(lattice.size)[:, None]
    moves = random.uniform(-0.4, 0.4, size=lattice.control_points.shape) @ spacing
    scene.replace(lattice.control_points + moves)
    return scene


class Watched:
    """The newest update of a scene, its plan, and where its patches come from."""

    def __init__(self, scene, normals="facet"):
        self.scene = scene
        view = latticed.View(encoding="patches", normals=normals)
        self.update = scene.get_update(view)
        self.plan = scene.patch_plan(self.update.topology.id, self.update.view.normals)
        self.source = scene.provenance(self.update)

    def evaluator(self, dtype=np.float32):
        return latticed.PatchEvaluator(self.plan, self.update.lattice, dtype)

    def at_levels(self, level, dtype=np.float32):
        return self.evaluator(dtype).at_levels(np.full(len(self.plan.edge_vertices), level))

    def exact(self, patch, weights):
        """The server's evaluation in double at points of patches."""
        barycentrics = np.einsum("pk,pki->pi", weights, self.source.barycentrics[patch]).clip(0, 1)
        return self.scene.evaluate_surface(self.source.faces[patch], self.source.corners[patch], barycentrics)


def some_points(surface, random, count=3000):
    """Random points of a surface: their numbers, patches and weights."""
    patch = np.repeat(np.arange(len(surface.patterns)), np.diff(surface.first_points))
    weights = np.concatenate([pattern.weights for pattern in surface.patterns])
    chosen = random.choice(len(patch), size=min(count, len(patch)), replace=False)
    return chosen, patch[chosen], weights[chosen]


def farthest_chord(watched, random, tolerance):
    """A surface for the tolerance, and how far random points of its triangles are from the exact surface."""
    surface = watched.evaluator(np.float64).surface(watched.update.edge_bytes, tolerance)
    corners = surface.triangles[random.choice(len(surface.triangles), size=4000)]
    patch = np.searchsorted(surface.first_points, corners[:, 0], side="right") - 1
    mix = random.dirichlet([1, 1, 1], size=len(corners))
    at = np.concatenate([pattern.weights for pattern in surface.patterns])
    exact = watched.exact(patch, np.einsum("tk,tki->ti", mix, at[corners]))
    chords = np.einsum("tk,tkx->tx", mix, surface.points[corners])
    far = np.linalg.norm(chords - exact.positions, axis=1).max()
    print(f"{len(surface.triangles)} triangles, {far / tolerance:.2f} of the tolerance")
    return surface, far


def half_unit(surface):
    """Of a grid of 16 bits around the surface, and 1e-6 of its diagonal."""
    extents = np.ptp(surface.points, axis=0)
    return extents.max() / 65535 / 2 + 1e-6 * np.linalg.norm(extents)


EVERY_DEGREE = pytest.mark.parametrize("degree", [(1, 1, 1), (2, 2, 2), (3, 3, 3), (3, 1, 2)])


@EVERY_DEGREE
def test_points_are_those_of_evaluate_points(client, blob, random, degree):
    with moved_scene(client, blob, random, degree) as scene:
        watched = Watched(scene)
        surface = watched.evaluator().surface(watched.update.edge_bytes, 1e-3)
        chosen, patch, weights = some_points(surface, random)
        exact = watched.exact(patch, weights)

    assert watched.update.revision == watched.update.lattice.revision == exact.revision == 1
    assert watched.plan.inside == len(watched.plan) == watched.update.topology.patches
    off = np.abs(surface.points[chosen] - exact.positions).max()
    print(f"{off / half_unit(surface):.2f} of what is allowed")
    assert off <= half_unit(surface)
    shared, across, different = shared_points(watched.plan, surface)
    print(f"{shared} points are shared, {across} of them across boxes")
    assert shared > 1500 and across > 200 and different == 0


def test_places_are_rounded_to_a_65535th_of_a_span(client, blob, random):
    """In a frame of one span that is ten times as wide as the mesh: half a unit of the frame, not of the mesh."""
    edges = np.diag([25.0, 26, 27])
    knots = np.array([0.0, 0, 0, 0, 1, 1, 1, 1])
    lattice = latticed.Lattice(
        np.zeros((4, 4, 4, 3)), (3, 3, 3), (knots,) * 3, -edges.sum(axis=0) / 2.2, edges
    )
    lattice.control_points = lattice.rest() + random.uniform(-2, 2, size=(4, 4, 4, 3))
    with client.create_scene(blob, lattice, delete_on_exit=True) as scene:
        watched = Watched(scene)
        surface = watched.evaluator().surface(watched.update.edge_bytes, 1e-3)
        chosen, patch, weights = some_points(surface, random)
        exact = watched.exact(patch, weights)

    off = np.abs(surface.points[chosen] - exact.positions)
    allowed = np.abs(exact.jacobians @ edges.T).sum(axis=2) / 131070
    print(
        f"{off.max() / half_unit(surface):.1f} half units of the surface, {(off / allowed).max():.2f} of what is allowed"
    )
    assert (off <= allowed + 1e-6 * np.linalg.norm(np.ptp(surface.points, axis=0))).all()
    assert off.max() > 2 * half_unit(surface)


@EVERY_DEGREE
@pytest.mark.parametrize("normals, radians", [("facet", 1.1e-4), ("smooth", 5e-5)])
def test_points_and_normals_are_those_of_the_uniform_view(client, blob, random, degree, normals, radians):
    with moved_scene(client, blob, random, degree) as scene:
        watched = Watched(scene, normals)
        surface = watched.at_levels(LEVEL)
        update = scene.get_update(latticed.View(normals=normals, **UNIFORM))

    points = update.points.reshape(-1, 3)
    np.testing.assert_array_equal(surface.triangles, update.triangles)
    assert np.abs(surface.points - points).max() <= half_unit(surface)
    off = np.linalg.norm(surface.normals - update.normals.reshape(-1, 3), axis=1)
    print(f"{np.median(off):.2g} rad, at most {off.max():.2g}")
    assert off.max() < radians


@EVERY_DEGREE
def test_triangles_are_within_the_tolerance(client, blob, random, degree):
    with moved_scene(client, blob, random, degree) as scene:
        watched = Watched(scene)
        for tolerance in (3e-2, 1e-3):
            surface, far = farthest_chord(watched, random, tolerance)
            assert tolerance / 20 < far <= tolerance + half_unit(surface)


@pytest.fixture
def half_in(client, blob, random):
    """A scene whose frame holds the blob's upper half and a part of its sides."""
    frame = dict(origin=np.array([-2.0, -0.7, -0.1]), edges=np.diag([4.0, 1.4, 2.0]))
    lattice = latticed.Lattice(
        np.zeros((4, 4, 5, 3)), (2, 2, 2), tuple(np.array(k) for k in (KNOTS_5, KNOTS_4, KNOTS_4)), **frame
    )
    lattice.control_points = lattice.rest()
    with client.create_scene(blob, lattice, delete_on_exit=True) as scene:
        yield scene


KNOTS_4 = [0.0, 0, 0, 1, 2, 2, 2]
KNOTS_5 = [0.0, 0, 0, 1, 1, 2, 2, 2]


@pytest.mark.parametrize("normals", ["facet", "smooth"])
def test_patches_outside_stay_and_seams_tear(half_in, random, normals):
    outside = Watched(half_in, normals)
    plan = outside.plan
    at_rest = outside.at_levels(LEVEL)
    attached = plan.seams.attached(outside.update.lattice)
    shared, across, different = shared_points(plan, at_rest)
    assert 100 < plan.inside < len(plan) - 100 and len(plan.seams.vertices) > 20
    assert attached.all() and different == 0 and across > 100

    lattice = half_in.lattice()
    half_in.move(lattice.indices[0, :, -1], (0.1, 0.2, -0.3))  # at the frame's lower face
    half_in.move(lattice.indices[2, 1:3, 1:4], (0.1, -0.1, 0.2))  # inside
    moved = Watched(half_in, normals)
    assert moved.plan.topology_id == plan.topology_id
    surface = moved.at_levels(LEVEL)
    attached = plan.seams.attached(moved.update.lattice)
    assert 0 < attached.sum() < len(attached)
    assert shared_points(plan, surface, torn=True)[2] == 0
    assert 10 < shared_points(plan, surface)[2] < across
    outside_points = slice(surface.first_points[plan.inside], None)
    np.testing.assert_array_equal(surface.points[outside_points], at_rest.points[outside_points])

    update = half_in.get_update(latticed.View(normals=normals, **UNIFORM))
    points, theirs = update.points.reshape(-1, 3), update.normals.reshape(-1, 3)
    assert np.abs(surface.points - points).max() <= half_unit(surface)
    assert np.linalg.norm(surface.normals - theirs, axis=1).max() < 1.1e-4


def test_a_stream_sends_bytes_of_edges_that_bend(client, blob, random):
    with moved_scene(client, blob, random) as scene, scene.deform(PATCHES) as stream:
        before = stream.latest
        plan = scene.patch_plan(before.topology.id)
        for step in range(1, 6):
            edit = stream.move(stream.lattice.indices[-1, :2, 0], (0.1 * step, 0, 0.2))
            update = stream.wait(edit, timeout=60)
            assert update.lattice.revision == update.revision
        whole = scene.get_update(PATCHES, min_revision=update.revision)

        assert before.bytes == len(plan.edge_vertices) == update.bytes
        np.testing.assert_array_equal(update.edge_bytes, whole.edge_bytes)
        np.testing.assert_array_equal(update.lattice.control_points, scene.lattice().control_points)
        changed = (update.edge_bytes != before.edge_bytes).mean()
        assert 0.01 < changed < 0.9
        ours = latticed.PatchEvaluator(plan, update.lattice).surface(update.edge_bytes, 1e-3)
        theirs = latticed.PatchEvaluator(plan, whole.lattice).surface(whole.edge_bytes, 1e-3)
        np.testing.assert_array_equal(ours.relative_points, theirs.relative_points)


def test_a_watch_changes_between_patches_and_points(client, blob, random):
    with moved_scene(client, blob, random) as scene, scene.watch(PATCHES) as stream:
        assert stream.latest.view.encoding == "patches" and stream.latest.edge_bytes.size
        stream.set_view(latticed.View(**UNIFORM))
        uniform = next(update for update in stream if update.view.encoding == "raw")
        stream.set_view(PATCHES)
        again = next(update for update in stream if update.view.encoding == "patches")
        plan = scene.patch_plan(again.topology.id, "none")

    assert uniform.topology.segments == 4 and again.topology.segments == 0
    assert again.certified_error == 0
    surface = latticed.PatchEvaluator(plan, again.lattice).at_levels(np.full(len(plan.edge_vertices), LEVEL))
    assert np.abs(surface.points - uniform.points.reshape(-1, 3)).max() <= half_unit(surface)


def test_new_knots_have_another_plan(client, blob, random):
    with moved_scene(client, blob, random) as scene, scene.deform(PATCHES) as stream:
        old = stream.latest
        plan = scene.patch_plan(old.topology.id)
        update = stream.wait(stream.insert_knot("u", 0.3), timeout=60)

        assert update.topology.id != old.topology.id
        other = scene.patch_plan(update.topology.id)
        before = latticed.PatchEvaluator(plan, old.lattice).surface(old.edge_bytes, 1e-3)
        after = latticed.PatchEvaluator(other, update.lattice).surface(update.edge_bytes, 1e-3)
        assert len(other) > len(plan)
        np.testing.assert_allclose(np.ptp(after.points, axis=0), np.ptp(before.points, axis=0), atol=2e-3)
        with pytest.raises(latticed.LatticedError) as refused:
            scene.patch_plan(old.topology.id)
        assert refused.value.code.name == "NOT_FOUND"


def test_plans_have_the_normals_that_are_asked_for(client, blob, random):
    with moved_scene(client, blob, random) as scene:
        update = scene.get_update(latticed.View(encoding="patches", normals="smooth"))
        assert update.view.normals == "smooth"
        assert scene.patch_plan(update.topology.id).normals == scene.default_view.normals == "facet"
        for normals in ("none", "facet", "smooth"):
            assert scene.patch_plan(update.topology.id, normals).normals == normals
        with pytest.raises(ValueError, match="normals is one of none, facet, smooth, not 'fine'"):
            scene.patch_plan(update.topology.id, "fine")
        with pytest.raises(latticed.LatticedError) as refused:
            scene.patch_plan("another")
        assert refused.value.code.name == "NOT_FOUND"
