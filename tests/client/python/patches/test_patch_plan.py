# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Patch plans without a server: a sheet's plan is written by the text of patches.proto, and read back."""
import dataclasses
import zlib

import latticed
import numpy as np
import pytest
from latticed.patches.plan_reader import read_plan

import plan_encoder
from sheet import Sheet
from lattices import moved_lattice


@pytest.fixture
def sheet(random):
    return Sheet(moved_lattice(random, (2, 1, 3)), random)


@pytest.mark.parametrize("normals", ["none", "facet", "smooth"])
def test_a_plan_is_read_as_it_was_written(sheet, random, normals):
    plan = read_plan(plan_encoder.plan_parts(sheet, normals, random))

    assert plan.topology_id == "sheet" and plan.normals == normals
    assert 0 < plan.inside == sheet.inside < len(plan)
    np.testing.assert_array_equal(plan.corners, sheet.corners)
    inside = np.unique(sheet.corners[: sheet.inside])
    np.testing.assert_array_equal(plan.places[inside], plan_encoder.places_in_frame(sheet)[inside])
    outside = plan.outside_corner_places[plan.inside :]
    np.testing.assert_array_equal(outside, plan_encoder.places_outside(sheet)[sheet.corners[plan.inside :]])
    edges, ends = plan_encoder.edges_by_first_use(sheet.corners)
    np.testing.assert_array_equal(plan.edges, edges)
    assert plan.edge_vertices.tolist() == [sorted(pair) for pair in ends]
    if normals == "facet":
        off = plan.rest_normals[plan.patch_normals] - sheet.facet_normals()
        assert np.abs(off).max() < 1e-4
    elif normals == "smooth":
        off = plan.rest_normals[plan.patch_normals] - sheet.vertex_normals()[sheet.corners]
        assert np.abs(off).max() <= 0.5 / 32767 + 1e-12
    else:
        assert plan.patch_normals.size == plan.rest_normals.size == 0


def test_patches_lie_in_the_box_of_their_corners(sheet, random):
    plan = read_plan(plan_encoder.plan_parts(sheet, "none", random))

    centres = sheet.shares[sheet.corners].mean(axis=1)[: plan.inside]
    for axis, breaks in enumerate(sheet.breaks):
        spans = np.searchsorted(breaks, centres[:, axis]) - 1
        np.testing.assert_array_equal(plan.spans[: plan.inside, axis], spans)
        assert len(np.unique(spans)) == len(breaks) - 1
    assert not plan.spans[plan.inside :].any()
    places = plan.corner_places
    assert places.min() == 0 and places.max() == 65535


@pytest.mark.parametrize("place, span", [(0, 0), (1, 0), (65535, 0), (65536, 1), (131070, 1), (196605, 2)])
def test_a_patch_in_a_knot_plane_lies_in_the_lower_box(sheet, random, place, span):
    plan = read_plan(plan_encoder.plan_parts(sheet, "none", random))
    vertices = plan.corners[0]
    places = plan.places.copy()
    places[vertices, 1] = place

    moved = dataclasses.replace(plan, places=places)

    assert moved.spans[0, 1] == span
    assert (moved.corner_places[0, :, 1] == place - 65535 * span).all()


def test_levels_follow_from_edge_bytes(sheet, random):
    plan = read_plan(plan_encoder.plan_parts(sheet, "none", random))
    edge_bytes = np.zeros(len(plan.edge_vertices), dtype=np.uint8)
    edge_bytes[:9] = [0, 39, 40, 41, 44, 48, 52, 56, 255]

    bounds = plan.edge_bounds(edge_bytes)
    levels = plan.levels(edge_bytes, 1 / 6)

    assert bounds[0] == 2.0**-20 and bounds[2] == 1 and bounds[4] == 4 and np.isinf(bounds[8])
    assert bounds[1] == pytest.approx(2**-0.5, rel=1e-15)
    # E is at most 1, 4, 16, 64, 256, and above
    assert levels[:9].tolist() == [0, 0, 0, 1, 1, 2, 3, 4, 5]
    assert plan.levels(edge_bytes, 1e-9).max() == 5
    each = np.full(len(plan.edge_vertices), 1 / 6)
    each[2] = 1 / 24
    assert plan.levels(edge_bytes, each)[:3].tolist() == [0, 0, 1]
    code = plan.codes(levels)[0]
    assert code == sum(levels[plan.edges[0, e]] * 8**e for e in range(3))


def test_wrong_arguments_are_refused(sheet, random):
    plan = read_plan(plan_encoder.plan_parts(sheet, "none", random))
    edge_bytes = np.zeros(len(plan.edge_vertices), dtype=np.uint8)

    with pytest.raises(ValueError, match="a tolerance is above 0, not 0"):
        plan.levels(edge_bytes, 0)
    with pytest.raises(ValueError, match="edges need one byte each, not the shape"):
        plan.levels(edge_bytes[1:], 0.1)


def damage(parts, kind):
    header, runs, seams = parts[0].header, [p.run for p in parts if p.HasField("run")], parts[-2].seams
    first = runs[0]
    if kind == "no header":
        return parts[1:]
    if kind == "two headers":
        return parts[:1] + parts
    if kind == "unspecified normals":
        header.normals = 0
    elif kind == "no zlib":
        first.data = b"\0" + first.data
    elif kind == "short":
        first.data = zlib.compress(zlib.decompress(first.data)[:-1])
    elif kind == "long":
        first.data = zlib.compress(zlib.decompress(first.data) + b"\0")
    elif kind == "huge":
        first.data = zlib.compress(bytes(10_000_000))
    elif kind == "truncated":
        first.data = first.data[:-5]
    elif kind == "a run is missing":
        return parts[:1] + parts[2:]
    elif kind == "the last run is missing":
        return parts[:-3]
    elif kind == "unknown vertex":
        raw = bytearray(zlib.decompress(first.data))
        raw[1] = 200
        first.data = zlib.compress(bytes(raw))
    elif kind == "more edges":
        header.edge_count += 1
    elif kind == "no unit":
        header.curvature_unit = 0
    elif kind == "empty box":
        header.outside_upper.x = header.outside_lower.x
    elif kind == "a seam is missing":
        del seams.edges[-1], seams.edge_seams[-1]
    elif kind == "unknown seam":
        seams.vertex_seams[0] = 1000
    elif kind == "not ascending":
        seams.vertices[0], seams.vertices[1] = seams.vertices[1], seams.vertices[0]
    elif kind == "incomplete":
        del seams.ranges[-1]
    elif kind == "past the box":
        seams.outside_places[0] = 65536
    return parts


@pytest.mark.parametrize(
    "kind, text",
    [
        ("no header", "one header, before all else"),
        ("two headers", "one header, before all else"),
        ("unspecified normals", "normals 0, which do not exist"),
        ("no zlib", "no zlib stream"),
        ("short", "does not hold the"),
        ("long", "does not hold the"),
        ("huge", "does not hold the"),
        ("truncated", "does not hold the"),
        ("a run is missing", "does not begin where the one before ends"),
        ("the last run is missing", "patches ended after"),
        ("unknown vertex", "uses vertices that it does not hold"),
        ("more edges", "edges instead of"),
        ("no unit", "the curvature unit"),
        ("empty box", "the outside box of a patch plan is empty"),
        ("a seam is missing", "not those of its patches"),
        ("unknown seam", "names a seam that it does not hold"),
        ("not ascending", "contradict each other"),
        ("incomplete", "are incomplete"),
        ("past the box", "outside of its patch's box"),
    ],
)
def test_damaged_plans_are_refused_in_a_sentence(sheet, random, kind, text):
    parts = damage(list(plan_encoder.plan_parts(sheet, "facet", random)), kind)

    with pytest.raises(latticed.LatticedError, match=text) as refused:
        read_plan(parts)
    assert refused.value.code.name == "DATA_LOSS"
