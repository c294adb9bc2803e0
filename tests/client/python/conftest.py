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
