# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The add-on's parts that need no Blender: the mapping of lattices, and the thread of a live session.
tests/client/blender compares whole surfaces with Blender's own modifier."""
import time

import latticed
import numpy as np
import pytest
from latticed_blender.axis_map import INTERPOLATIONS, TENSIONS, map_axis
from latticed_blender.lattice_map import BlenderLattice
from latticed_blender.live_session import LiveSession
from latticed_blender.source_mesh import SourceMesh

import definition

VIEW = latticed.View(segments=3, normals="facet", encoding="quantised", position_bits=16)


def weights(interpolation, t):
    """Blender's weights of the lattice points -1, 0, 1 and 2 at t, 0 to 1 (key_curve_position_weights)."""
    if interpolation == "KEY_LINEAR":
        return np.array([0, 1 - t, t, 0])
    if interpolation == "KEY_BSPLINE":
        return (
            np.array(
                [(1 - t) ** 3, 3 * t**3 - 6 * t**2 + 4, -3 * t**3 + 3 * t**2 + 3 * t + 1, t**3]
            )
            / 6
        )
    c = TENSIONS[interpolation]
    return np.array(
        [
            -c * t**3 + 2 * c * t**2 - c * t,
            (2 - c) * t**3 + (c - 3) * t**2 + 1,
            (c - 2) * t**3 + (3 - 2 * c) * t**2 + c * t,
            c * t**3 - c * t**2,
        ]
    )


def blender_rows(interpolation, count, x):
    """The weight of each lattice point at x. In place of a missing point Blender takes the nearest one."""
    shares = np.zeros(count)
    if count == 1:
        return np.ones(1)
    first = int(np.floor(x))
    for k, weight in zip(range(-1, 3), weights(interpolation, x - first)):
        shares[min(max(first + k, 0), count - 1)] += weight
    return shares


@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
@pytest.mark.parametrize("count", [1, 2, 3, 6])
@pytest.mark.parametrize("beyond", [(0, 0), (0.25, 0), (0, 1.5), (7.3, 0.01)])
def test_an_axis_is_blenders_everywhere_on_the_mesh(interpolation, count, beyond):
    low, high = -beyond[0], max(count - 1, 0) + beyond[1]

    axis = map_axis(interpolation, count, low, high)

    assert axis.domain[0] <= low and high <= axis.domain[1]
    assert len(axis.knots) == len(axis.weights) + axis.degree + 1 and len(axis.weights) > axis.degree
    greville = [axis.knots[i + 1 : i + 1 + axis.degree].mean() for i in range(len(axis.weights))]
    places = np.linspace(low, high, 41)
    for x, shares in zip(places, definition.basis(axis.knots, axis.degree, places)):
        np.testing.assert_allclose(shares @ axis.weights, blender_rows(interpolation, count, x), atol=1e-12)
        assert shares @ greville == pytest.approx(x, abs=1e-12)  # without displacements the point stays


def test_an_unknown_interpolation_is_refused():
    with pytest.raises(ValueError, match="KEY_WAVES"):
        map_axis("KEY_WAVES", 3, 0, 2)


def grid(random, interpolation=("KEY_BSPLINE", "KEY_LINEAR", "KEY_CARDINAL"), counts=(4, 3, 5), scale=0.2):
    """A lattice at an angle to the mesh. The mesh reaches out of the lattice."""
    w, v, u = (np.linspace(-0.5, 0.5, n) for n in reversed(counts))
    rest = np.stack(np.meshgrid(w, v, u, indexing="ij")[::-1], axis=-1)
    to_mesh = np.eye(4)
    to_mesh[:3] = [[0.7, -0.2, 0.1, 0.6], [0.3, 0.9, 0.0, 0.4], [0.0, 0.1, 1.2, 0.5]]
    return BlenderLattice(rest, rest + scale * random.standard_normal(rest.shape), interpolation, to_mesh)


@pytest.fixture
def session(server, random):
    mesh = SourceMesh(np.array(definition.BOX_POSITIONS, np.float32), np.array(definition.BOX_FACES))
    made = LiveSession(server.address, mesh, grid(random, scale=0.0), VIEW)
    yield made
    made.close()


def newest(session, revision=0):
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline and session.running:
        surface = session.take()
        if surface is not None and surface.revision >= revision:
            return surface
        time.sleep(0.005)
    pytest.fail(f"nothing came: {session.status}")


def test_states_in_between_are_left_out_and_the_last_one_is_shown(session, random):
    rest = newest(session).positions.astype(float)
    lattice = grid(random, scale=0.0)
    for step in range(1, 201):
        moved = lattice.rest + [0, 0, step / 200]
        last = BlenderLattice(lattice.rest, moved, lattice.interpolation, lattice.to_mesh)
        session.change(grid=last)

    expected = rest + lattice.to_mesh[:3, 2]
    surface = newest(session, revision=1)
    while np.abs(surface.positions - expected).max() > 1e-3:
        surface = newest(session)
    assert surface.revision < 200


def test_closing_deletes_the_scene(session, client):
    newest(session)
    assert len(client.scenes("client=blender")) == 1

    session.close()

    assert client.scenes("client=blender") == [] and not session.running
    assert session.status == "Disconnected"


def test_failures_are_told_in_words(random):
    mesh = SourceMesh(np.array(definition.BOX_POSITIONS, np.float32), np.array(definition.BOX_FACES))
    nobody = LiveSession("127.0.0.1:1", mesh, grid(random), VIEW)
    flat = grid(random)
    flat.to_mesh[:3, 0] = 0
    squashed = LiveSession("127.0.0.1:1", mesh, flat, VIEW)
    for session in (nobody, squashed):
        session._thread.join(timeout=60)

    assert nobody.status == "No server answers at 127.0.0.1:1" and not nobody.running
    assert "flat" in squashed.status
