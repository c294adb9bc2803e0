# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Events made by hand for one patch of one triangle: some as a server sends them, some as no server does."""
import grpc
import latticed
import numpy as np
import pytest
from latticed import draco
from latticed.surface import Surface
from latticed.v1 import event_pb2, lattice_pb2, view_pb2

RAW = view_pb2.ViewOptions(encoding=view_pb2.ENCODING_RAW, normals=view_pb2.NORMAL_MODE_NONE)
TRIANGLE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4")


def event(**arm):
    return event_pb2.SceneEvent(**arm)


def lattice(structure_id=1):
    state = lattice_pb2.LatticeState(structure_id=structure_id)
    state.lattice.frame.u.x = state.lattice.frame.v.y = state.lattice.frame.w.z = 1
    return event(lattice_state=state)


def topology(name="t", chunks=1):
    pattern = event_pb2.TessellationPattern(points=[1, 0, 0, 0, 1, 0, 0, 0, 1], triangles=[0, 1, 2])
    runs = [event_pb2.ChunkRun(chunk_count=chunks, patches_per_chunk=1)]
    counts = {"patch_count": chunks, "point_count": 3 * chunks, "triangle_count": chunks, "segments": 1}
    return event(topology=event_pb2.Topology(topology_id=name, chunk_runs=runs, pattern=pattern, **counts))


def by_tolerance(name="a"):
    runs = [event_pb2.ChunkRun(chunk_count=1, patches_per_chunk=1)]
    return event(topology=event_pb2.Topology(topology_id=name, chunk_runs=runs, patch_count=1))


def patterns(denominator=1, triangles=(0, 1, 2)):
    sent = {
        "code": 513,
        "denominator": denominator,
        "points": [1, 0, 0, 0, 1, 0, 0, 0, 1],
        "triangles": triangles,
    }
    return event(patterns=event_pb2.Patterns(patterns=[event_pb2.PatchPattern(**sent)]))


def quantisation(number=1):
    return event(quantisation=event_pb2.Quantisation(quantisation_id=number, origin={"x": 5}))


def begin(update_id=1, chunks=1, view=RAW):
    return event(update_begin=event_pb2.UpdateBegin(update_id=update_id, chunk_count=chunks, view=view))


def chunks(update_id=1, index=0, data=TRIANGLE.tobytes(), topology_id="t", quantisation_id=1, levels=b""):
    held = [event_pb2.Chunk(index=index, data=data, revision=update_id, levels=levels)]
    return event(
        chunks=event_pb2.Chunks(
            update_id=update_id, topology_id=topology_id, quantisation_id=quantisation_id, chunks=held
        )
    )


def end(update_id=1):
    return event(update_end=event_pb2.UpdateEnd(update_id=update_id, revision=update_id, head_revision=2))


def delta(indices, positions):
    return event(
        lattice_delta=event_pb2.LatticeDelta(structure_id=1, revision=1, indices=indices, positions=positions)
    )


START = [lattice(), topology(), quantisation()]
ADAPTIVE = [by_tolerance(), begin()]


def updates(events):
    surface = Surface()
    return [update for update in map(surface.apply, events) if update is not None]


def test_an_update_is_here_when_it_ends():
    (update,) = updates([*START, begin(), chunks(), end()])

    np.testing.assert_array_equal(update.points, [TRIANGLE + [5, 0, 0]])
    np.testing.assert_array_equal(update.relative_points, [TRIANGLE])
    np.testing.assert_array_equal(update.triangles, [[0, 1, 2]])
    assert (update.revision, update.final, update.normals) == (1, False, None)


def test_levels_name_the_patterns_of_patches():
    sent = chunks(topology_id="a", levels=b"\1\2")

    (update,) = updates([*START, by_tolerance(), begin(), patterns(), sent, end()])

    np.testing.assert_array_equal(update.points, TRIANGLE + [5, 0, 0])
    np.testing.assert_array_equal(update.triangles, [[0, 1, 2]])
    np.testing.assert_array_equal(update.first_points, [0, 3])


def test_an_update_that_is_begun_again_forgets_its_chunks():
    moved = (TRIANGLE + 1).tobytes()

    (update,) = updates([*START, begin(), chunks(), begin(2), chunks(2, data=moved), end(2)])

    np.testing.assert_array_equal(update.relative_points, [TRIANGLE + 1])


def test_what_was_handed_out_does_not_change():
    surface = Surface()
    for early in START:
        surface.apply(early)
    before = surface.lattice.control_points[0, 0, 0].copy()
    held = surface.lattice

    surface.apply(delta([0], [7, 8, 9]))

    np.testing.assert_array_equal(held.control_points[0, 0, 0], before)
    np.testing.assert_array_equal(surface.lattice.control_points[0, 0, 0], [7, 8, 9])
    assert surface.lattice.revision == 1


@pytest.mark.parametrize(
    "events, text",
    [
        ([chunks()], "outside of their update"),
        ([begin(), chunks(2)], "outside of their update"),
        ([begin(), chunks(quantisation_id=2)], "a quantisation that was not sent"),
        ([begin(), chunks(topology_id="u")], "a topology that was not sent"),
        ([begin(), chunks(index=1)], "chunk 1 of 1"),
        ([end()], "without its update_begin"),
        ([begin(), chunks(), end(2)], "without its update_begin"),
        ([begin(chunks=2), chunks(), end()], "2 chunks ended after 1"),
        ([topology("u", 2), begin(), chunks(topology_id="u"), end()], "before every chunk had come"),
        ([begin(chunks=0), end()], "before every chunk had come"),
        ([*ADAPTIVE, chunks(topology_id="a", levels=b"\1\2")], "no patterns that were sent"),
        ([*ADAPTIVE, patterns(), chunks(topology_id="a")], "no patterns that were sent"),
        ([*ADAPTIVE, patterns(), chunks(topology_id="a", levels=b"\1\2\1\2")], "no patterns that were sent"),
        ([patterns(denominator=0)], "a pattern contradicts itself"),
        ([patterns(triangles=(0, 1, 3))], "a pattern contradicts itself"),
        ([patterns(triangles=(0, 1))], "a pattern contradicts itself"),
        ([delta([0], [1, 2])], "three numbers per index"),
        ([delta([64], [1, 2, 3])], "a control point that does not exist"),
    ],
)
def test_events_that_contradict_each_other_are_data_loss(events, text):
    with pytest.raises(latticed.LatticedError, match=text) as caught:
        updates([*START, *events])

    assert caught.value.code == grpc.StatusCode.DATA_LOSS


@pytest.mark.parametrize(
    "encoding, data, text",
    [
        (view_pb2.ENCODING_RAW, bytes(35), "35 bytes instead of 36"),
        (view_pb2.ENCODING_QUANTISED, bytes(19), "19 bytes instead of 18"),
        (view_pb2.ENCODING_CONTROL_NETS, bytes(36), "encoding 5, which this client does not know"),
        (view_pb2.ENCODING_MESHOPT, b"junk", "a chunk is no meshopt stream of its view"),
        (view_pb2.ENCODING_DRACO_POINTS, b"junk", "DracoPy: no Draco"),
    ],
)
def test_a_chunk_that_is_not_as_announced_is_data_loss(encoding, data, text, monkeypatch):
    class Decoder:
        @staticmethod
        def decode(data):
            raise TypeError("no Draco")

    monkeypatch.setattr(draco, "draco_py", lambda: Decoder)
    view = view_pb2.ViewOptions(encoding=encoding, normals=view_pb2.NORMAL_MODE_NONE)
    (update,) = updates([*START, begin(view=view), chunks(data=data), end()])

    with pytest.raises(latticed.LatticedError, match=text) as caught:
        update.points

    assert caught.value.code == grpc.StatusCode.DATA_LOSS
