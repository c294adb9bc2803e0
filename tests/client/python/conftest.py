# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
import latticed
import numpy as np
import pytest

import definition
from server_process import ServerProcess


@pytest.fixture(scope="session")
def server():
    with ServerProcess() as process:
        yield process


@pytest.fixture
def client(server):
    with latticed.connect(server.address) as connected:
        yield connected


@pytest.fixture
def box(client):
    return client.upload_arrays(definition.BOX_POSITIONS, definition.BOX_FACES, name="box", progress=False)


@pytest.fixture
def scene(client, box):
    """A scene of the box with 4 x 3 x 5 control points: a test that swaps two axes fails."""
    view = latticed.View(segments=4, encoding="quantised", position_bits=16, normal_bits=12)
    with client.create_scene(box, size=(4, 3, 5), degree=(3, 1, 2), view=view, delete_on_exit=True) as made:
        yield made


@pytest.fixture
def random():
    seed = 20261121
    print(f"seed {seed}")
    return np.random.default_rng(seed)


@pytest.fixture
def blob(client, random):
    """A closed mesh of 264 triangles around the origin, about 2 wide."""
    turns, rings = 12, 12
    angle, height = np.meshgrid(np.arange(turns) * 2 * np.pi / turns, np.linspace(0, np.pi, rings + 1)[1:-1])
    sphere = np.stack(
        [np.sin(height) * np.cos(angle), np.sin(height) * np.sin(angle), np.cos(height)], axis=-1
    )
    points = np.concatenate([sphere.reshape(-1, 3), [[0, 0, 1], [0, 0, -1]]])
    points *= random.uniform(0.8, 1.2, size=(len(points), 1))
    a = np.arange(turns)
    b = (a + 1) % turns
    faces = [np.stack([a, b, np.full(turns, len(points) - 2)], axis=-1)[:, [2, 0, 1]]]
    for ring in range(0, (rings - 2) * turns, turns):
        faces += [np.stack([ring + a, ring + turns + a, ring + b], axis=-1)]
        faces += [np.stack([ring + b, ring + turns + a, ring + turns + b], axis=-1)]
    last = (rings - 2) * turns
    faces += [np.stack([last + a, np.full(turns, len(points) - 1), last + b], axis=-1)]
    return client.upload_arrays(points, np.concatenate(faces), progress=False)
