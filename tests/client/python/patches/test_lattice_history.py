# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Each update of a stream has the lattice of its own revision, although edits are reported before their updates."""
import gc

import latticed
import numpy as np
import pytest
from latticed.errors import LatticedError
from latticed.surface import Surface
from latticed.v1 import event_pb2, lattice_pb2, view_pb2

from lattices import moved_lattice

EDGES = bytes([3, 255, 40])


def state(lattice, revision):
    return event_pb2.SceneEvent(
        lattice_state=lattice_pb2.LatticeState(lattice=lattice.to_proto(), structure_id=1, revision=revision)
    )


def delta(revision, x):
    moved = event_pb2.LatticeDelta(structure_id=1, revision=revision, indices=[5], positions=[x, 0, 0])
    return event_pb2.SceneEvent(lattice_delta=moved)


def update(surface, revision, update_id=1, parts=None, total=None):
    """Sends an update of three edges in two chunks, and returns it. It has no quantisation.

    parts  the messages of its chunks; None: one for each chunk
    total  the sum of several lattices; None: there is one
    """
    view = view_pb2.ViewOptions(encoding=view_pb2.ENCODING_PATCHES, normals=view_pb2.NORMAL_MODE_FACET)
    runs = [event_pb2.ChunkRun(chunk_count=2, patches_per_chunk=1)]
    topology = event_pb2.Topology(topology_id="t", patch_count=2, chunk_runs=runs)
    if parts is None:
        parts = [
            event_pb2.Chunk(index=0, data=EDGES[:2]),
            event_pb2.Chunk(index=1, first_edge=2, data=EDGES[2:]),
        ]
    count = sum(max(part.chunk_count, 1) for part in parts)
    begin = event_pb2.UpdateBegin(update_id=update_id, revision=revision, chunk_count=count, view=view)
    chunks = event_pb2.Chunks(update_id=update_id, topology_id="t", chunks=parts)
    end = event_pb2.UpdateEnd(update_id=update_id, revision=revision)
    arms_of_sum = (
        [] if total is None else [dict(patch_lattice=event_pb2.PatchLattice(state=total.lattice_state))]
    )
    for arms in (dict(topology=topology), dict(update_begin=begin), *arms_of_sum, dict(chunks=chunks)):
        assert surface.apply(event_pb2.SceneEvent(**arms)) is None
    return surface.apply(event_pb2.SceneEvent(update_end=end))


def test_an_update_has_the_lattice_of_its_revision(random):
    surface, lattice = Surface(), moved_lattice(random, (2, 2, 2))
    for event in (state(lattice, 1), delta(2, 20), delta(3, 30), delta(4, 40)):
        surface.apply(event)

    for number, (revision, x) in enumerate([(2, 20), (3, 30), (4, 40)], start=1):
        held = update(surface, revision, number)
        assert held.lattice.revision == revision
        np.testing.assert_array_equal(held.lattice.control_points.reshape(-1, 3)[5], [x, 0, 0])
    assert surface.lattice.revision == 4


def test_an_update_has_the_strength_of_its_revision(random):
    surface, lattice = Surface(), moved_lattice(random, (2, 2, 2))
    weaker = event_pb2.LatticeDelta(structure_id=1, revision=2, strength=0.25)
    for event in (state(lattice, 1), event_pb2.SceneEvent(lattice_delta=weaker), delta(3, 30)):
        surface.apply(event)
    assert [update(surface, revision, revision).lattice.strength for revision in (1, 2, 3)] == [1, 0.25, 0.25]


def test_a_newer_state_stands_in_for_a_lattice_that_was_skipped(random):
    surface, lattice = Surface(), moved_lattice(random, (2, 2, 2))
    surface.apply(state(lattice, 1))
    assert update(surface, 1, 1).lattice.revision == 1

    surface.apply(state(lattice, 9))
    surface.apply(delta(10, 20))
    assert update(surface, 7, 2).lattice.revision == 9
    assert update(surface, 9, 3).lattice.revision == 9

    surface.apply(state(lattice, 3))  # the server has started again
    assert surface.lattice.revision == 3 and update(surface, 3, 4).lattice.revision == 3


def test_lattices_of_earlier_updates_are_forgotten_also_beside_a_sum(random):
    surface, lattice = Surface(), moved_lattice(random, (2, 2, 2))
    surface.apply(state(lattice, 1))
    for revision in range(2, 52):
        surface.apply(delta(revision, revision))
        update(surface, revision, revision, total=state(lattice, revision))
    held = [each for each in gc.get_objects() if isinstance(each, latticed.Lattice)]
    assert len(held) < 10


def test_an_update_of_patches_has_edge_bytes_and_no_points(random):
    surface = Surface()
    surface.apply(state(moved_lattice(random, (2, 2, 2)), 1))

    held = update(surface, 1)

    assert held.edge_bytes.tolist() == list(EDGES) and held.bytes == 3
    assert held.view.encoding == "patches" and held.view.normals == "facet"
    for name in ("points", "relative_points", "normals", "triangles", "patterns", "first_points"):
        with pytest.raises(ValueError, match="has no points: PatchEvaluator makes them"):
            getattr(held, name)
    with pytest.raises(ValueError, match="has no points"):
        held.points_of(0)


def test_consecutive_chunks_of_bounds_come_as_one():
    surface = Surface()
    both = event_pb2.Chunk(index=0, chunk_count=2, data=EDGES)
    first = update(surface, 1, 1, [both])
    second = update(surface, 2, 2, [event_pb2.Chunk(index=1, first_edge=2, data=b"x")])

    assert first.edge_bytes.tolist() == list(EDGES) and first.bytes == 3
    assert second.edge_bytes.tolist() == [*EDGES[:2], ord("x")] and second.bytes == 3
    assert second.changed_since(first) == [1]


@pytest.mark.parametrize(
    "part",
    [
        event_pb2.Chunk(index=1, chunk_count=2, data=EDGES),  # the topology has two chunks
        event_pb2.Chunk(
            index=0, chunk_count=2, first_edge=4, data=EDGES
        ),  # and its two patches at most 6 edges
    ],
)
def test_bounds_of_what_the_topology_does_not_have_are_refused(part):
    with pytest.raises(LatticedError) as refused:
        update(Surface(), 1, 1, [part])
    assert refused.value.code.name == "DATA_LOSS"


def test_other_updates_have_no_edge_bytes(scene):
    with pytest.raises(ValueError, match="the encoding 'quantised' has no edge bytes"):
        scene.get_update().edge_bytes
