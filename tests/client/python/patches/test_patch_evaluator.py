# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""PatchEvaluator without a server, against the definition of the deformation in double precision."""
import latticed
import numpy as np
import pytest
from latticed.patches.plan_reader import read_plan

import definition
from lattices import moved_lattice
from plan_encoder import plan_parts
from shared_points import shared_points
from sheet import Sheet

FULL_MULTIPLICITY = [0, 0, 0, 1, 1, 1.5, 2, 3, 3, 3]  # degree 2: the surface has a crease at 1
UNCLAMPED = np.arange(-2.0, 6.0)  # degree 2, domain 0 to 3
LATTICES = {
    "degrees 1 1 1": lambda random: moved_lattice(random, (1, 1, 1)),
    "degrees 2 2 2": lambda random: moved_lattice(random, (2, 2, 2)),
    "degrees 3 3 3": lambda random: moved_lattice(random, (3, 3, 3)),
    "degrees 1 2 3, left-handed": lambda random: moved_lattice(random, (1, 2, 3), left_handed=True),
    "crease, unclamped": lambda random: moved_lattice(
        random, (2, 2, 1), [np.array(FULL_MULTIPLICITY), UNCLAMPED, np.array([5.0, 5, 6, 8, 8])]
    ),
}
EVERY_LATTICE = pytest.mark.parametrize("make", LATTICES.values(), ids=LATTICES.keys())


def levels_of(plan, random):
    """Any levels, and more often low ones, so that all kinds of patterns meet."""
    return random.choice(6, p=[0.3, 0.3, 0.2, 0.1, 0.05, 0.05], size=len(plan.edge_vertices))


def shares_of(sheet, surface, patches):
    """The points of these patches by their place in the frame."""
    return np.concatenate([surface.patterns[p].weights @ sheet.shares[sheet.corners[p]] for p in patches])


def of_patches(surface, values, patches):
    return np.concatenate([values[surface.first_points[p] : surface.first_points[p + 1]] for p in patches])


def diagonal(points):
    return np.linalg.norm(np.ptp(points, axis=0))


@EVERY_LATTICE
@pytest.mark.parametrize("dtype, rounding", [(np.float32, 1e-6), (np.float64, 1e-12)])
def test_positions_match_the_definition(random, make, dtype, rounding):
    lattice = make(random)
    sheet = Sheet(lattice, random)
    plan = read_plan(plan_parts(sheet, "none", random))

    surface = latticed.PatchEvaluator(plan, lattice, dtype).at_levels(levels_of(plan, random))

    assert surface.normals is None and surface.relative_points.dtype == dtype
    patches = random.choice(plan.inside, size=60, replace=False)
    points = of_patches(surface, surface.points, patches)
    exact = definition.deform_shares(lattice, shares_of(sheet, surface, patches).clip(0, 1))
    half_unit = np.ptp(surface.points, axis=0).max() / 65535 / 2
    far = np.abs(points - exact).max()
    print(f"{far / half_unit:.3f} of half a unit of 16 bits")
    assert far <= half_unit + rounding * diagonal(surface.points)


@EVERY_LATTICE
def test_points_that_patches_share_have_the_same_bits(random, make):
    lattice = make(random)
    sheet = Sheet(lattice, random)
    plan = read_plan(plan_parts(sheet, "none", random))

    surface = latticed.PatchEvaluator(plan, lattice).at_levels(levels_of(plan, random))
    shared, across, different = shared_points(plan, surface, torn=True)

    print(f"{shared} points are shared, {across} of them across boxes")
    assert shared > 1000 and across > 100 and different == 0


def carried(lattice, sheet, patch, shares, rest):
    """The unit vectors along cof(J) n in the patch's own box, and the condition of each, ||cof J|| |n| / |cof(J) n|. J
    is by differences of the definition, towards the middle of the box."""
    box = []
    centre = sheet.shares[sheet.corners[patch]].mean(axis=0)
    for breaks, at in zip(sheet.breaks, centre):
        span = np.searchsorted(breaks, at) - 1
        box.append(breaks[span : span + 2])
    low, high = np.array(box).T
    columns = []
    for axis in range(3):
        step = np.zeros_like(shares)
        step[:, axis] = np.where(shares[:, axis] < (low + high)[axis] / 2, 1e-4, -1e-4)
        at = [definition.deform_shares(lattice, shares.clip(low, high) + k * step) for k in range(3)]
        columns.append((-3 * at[0] + 4 * at[1] - at[2]) / (2 * step[:, [axis]]))
    jacobians = np.stack(columns, axis=-1) @ np.linalg.inv(lattice.edges.T)
    cofactors = np.linalg.det(jacobians)[:, None, None] * np.linalg.inv(jacobians).transpose(0, 2, 1)
    normals = np.einsum("pij,pj->pi", cofactors, rest)
    lengths = np.linalg.norm(normals, axis=1)
    conditions = np.linalg.norm(cofactors, axis=(1, 2)) * np.linalg.norm(rest, axis=1) / lengths
    return normals / lengths[:, None], conditions


# How far the rest normals of a plan may be from exact ones, radians. Facet: s and t are off by half a unit, so y and
# z by 1 / 65534 and x by twice that, of a vector that is at least 1 / sqrt(3) long. Smooth: half a unit on each axis.
FACET_ERROR = np.sqrt(6) * np.sqrt(3) / 65534
SMOOTH_ERROR = np.sqrt(3) / 2 / 32767
EVALUATION_ERROR = 2e-5  # of the evaluation in single precision, from places of 16 bits


@EVERY_LATTICE
@pytest.mark.parametrize("mode, rest_error", [("facet", FACET_ERROR), ("smooth", SMOOTH_ERROR)])
def test_normals_are_carried_by_the_deformation(random, make, mode, rest_error):
    lattice = make(random)
    sheet = Sheet(lattice, random)
    plan = read_plan(plan_parts(sheet, mode, random))

    surface = latticed.PatchEvaluator(plan, lattice).at_levels(levels_of(plan, random).clip(0, 2))

    np.testing.assert_allclose(np.linalg.norm(surface.normals, axis=1), 1, atol=1e-6)
    worst = 0
    for patch in random.choice(plan.inside, size=40, replace=False):
        weights = surface.patterns[patch].weights
        shares = shares_of(sheet, surface, [patch])
        rest = np.tile(sheet.facet_normals()[patch], (len(shares), 1))
        if mode == "smooth":
            rest = weights @ sheet.vertex_normals()[sheet.corners[patch]]
        exact, conditions = carried(lattice, sheet, patch, shares, rest)
        off = np.linalg.norm(of_patches(surface, surface.normals, [patch]) - exact, axis=1)
        allowed = conditions * (rest_error / np.linalg.norm(rest, axis=1) + EVALUATION_ERROR)
        worst = max(worst, (off / allowed).max())
    print(f"{worst:.2f} of what is allowed")
    assert worst < 1


def test_normals_point_the_same_way_in_a_left_handed_frame(random):
    """At rest the deformation is the identity, so that normals are those of the mesh."""
    for left_handed in (False, True):
        lattice = moved_lattice(random, (2, 3, 1), left_handed=left_handed, move=0)
        sheet = Sheet(lattice, random)
        plan = read_plan(plan_parts(sheet, "facet", random))

        surface = latticed.PatchEvaluator(plan, lattice).at_levels(
            np.zeros(len(plan.edge_vertices), dtype=int)
        )

        rest = np.repeat(sheet.facet_normals(), 3, axis=0)
        assert np.linalg.norm(surface.normals - rest, axis=1).max() < FACET_ERROR + EVALUATION_ERROR
        a, b, c = surface.points[surface.triangles].transpose(1, 0, 2)
        assert (np.einsum("tx,tx->t", np.cross(b - a, c - a), rest[::3]) > 0).all()


def test_where_the_deformation_has_no_normal_there_is_the_one_at_rest(random):
    lattice = moved_lattice(random, (2, 2, 2))
    sheet = Sheet(lattice, random)
    plan = read_plan(plan_parts(sheet, "facet", random))
    lattice.control_points[:] = [1.0, 2, 3]  # all of the frame goes to one point

    surface = latticed.PatchEvaluator(plan, lattice).at_levels(np.ones(len(plan.edge_vertices), dtype=int))

    rest = np.repeat(sheet.facet_normals(), 6, axis=0)
    assert np.linalg.norm(surface.normals - rest, axis=1).max() < FACET_ERROR + 1e-6
    inside = surface.points[: surface.first_points[plan.inside]]
    np.testing.assert_allclose(inside, np.broadcast_to([1.0, 2, 3], inside.shape), atol=1e-5)


def test_patches_outside_stay_where_they_are(random):
    lattice = moved_lattice(random, (2, 2, 2))
    sheet = Sheet(lattice, random)
    plan = read_plan(plan_parts(sheet, "smooth", random))

    surface = latticed.PatchEvaluator(plan, lattice).at_levels(levels_of(plan, random))

    outside = range(plan.inside, len(plan))
    rest = np.concatenate([surface.patterns[p].weights @ sheet.at_rest[p] for p in outside])
    half_unit = np.ptp(sheet.world, axis=0).max() / 65535 / 2
    far = np.abs(of_patches(surface, surface.points, outside) - rest).max()
    assert far <= half_unit + 1e-6 * diagonal(sheet.world)
    normals = sheet.vertex_normals()[sheet.corners]
    exact = np.concatenate([surface.patterns[p].weights @ normals[p] for p in outside])
    lengths = np.linalg.norm(exact, axis=1, keepdims=True)
    off = np.abs(of_patches(surface, surface.normals, outside) - exact / lengths)
    assert (off <= 2 * SMOOTH_ERROR / lengths + 1e-6).all()


def test_seams_are_attached_while_their_control_points_have_not_moved(random):
    lattice = moved_lattice(random, (2, 2, 2), move=0)
    sheet = Sheet(lattice, random)
    plan = read_plan(plan_parts(sheet, "none", random))
    levels = levels_of(plan, random)
    border = np.isin(plan.corners, plan.seams.vertices)

    at_rest = latticed.PatchEvaluator(plan, lattice).at_levels(levels)
    shared, across, different = shared_points(plan, at_rest)
    assert shared > 1000 and across > 200 and different == 0
    assert plan.seams.attached(lattice).all() and border[: plan.inside].any()

    lattice.control_points[:, :, -1] += [0.5, 0, 0]  # the last layer of the first axis
    torn = latticed.PatchEvaluator(plan, lattice).at_levels(levels)
    attached = plan.seams.attached(lattice)
    assert 0 < attached.sum() < len(attached)
    assert (plan.seams.ranges[~attached][:, 0, 1] == lattice.size[0] - 1).all()
    assert shared_points(plan, torn, torn=True)[2] == 0
    assert 10 < shared_points(plan, torn)[2] < across, "points of torn seams differ, all others do not"
    np.testing.assert_array_equal(
        torn.points[torn.first_points[plan.inside] :], at_rest.points[torn.first_points[plan.inside] :]
    )

    lattice.control_points[:, :, -1] = lattice.rest()[:, :, -1]
    again = latticed.PatchEvaluator(plan, lattice).at_levels(levels)
    np.testing.assert_array_equal(again.points, at_rest.points)


def test_triangles_join_the_points_of_patches(random):
    lattice = moved_lattice(random, (2, 2, 2))
    sheet = Sheet(lattice, random)
    plan = read_plan(plan_parts(sheet, "none", random))
    levels = levels_of(plan, random)

    surface = latticed.PatchEvaluator(plan, lattice).at_levels(levels)

    assert len(surface.points) == surface.first_points[-1] == sum(len(p) for p in surface.patterns)
    assert surface.triangles.max() == len(surface.points) - 1
    patch = np.searchsorted(surface.first_points, surface.triangles, side="right")
    assert (patch == patch[:, :1]).all()
    for p in range(5):
        for e in range(3):
            on_edge = surface.patterns[p].points[:, (e + 2) % 3] == 0
            assert on_edge.sum() == 2 ** levels[plan.edges[p, e]] + 1


def test_a_plan_of_other_knots_is_refused(random):
    lattice = moved_lattice(random, (2, 2, 2))
    plan = read_plan(plan_parts(Sheet(lattice, random), "none", random))

    with pytest.raises(latticed.LatticedError, match="spans that the lattice does not have"):
        latticed.PatchEvaluator(plan, moved_lattice(random, (2, 2, 2), spans=(3, 2, 3)))
    with pytest.raises(latticed.LatticedError, match="those of another lattice"):
        latticed.PatchEvaluator(plan, moved_lattice(random, (2, 2, 2), spans=(3, 2, 5)))
