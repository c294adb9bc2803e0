# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
import random
import subprocess

import latticed
import numpy as np
import pytest

from server_process import LATTICECTL, ServerProcess


@pytest.fixture
def backup(client, scene, tmp_path):
    """A file with the scene, which has been edited."""
    scene.move([0], (1, 0, 0))
    scene.insert_knot("u", 0.25)
    return tmp_path / "server.backup"


@pytest.fixture
def empty():
    with ServerProcess() as server, latticed.connect(server.address) as client:
        yield client


def test_a_backup_makes_the_same_on_another_server_with_its_undo_steps(client, scene, backup, empty):
    done = client.backup(backup, [scene])

    assert (done.meshes, done.scenes, done.damaged) == (1, 1, [])
    assert done.bytes == backup.stat().st_size
    assert not backup.with_name("server.backup.part").exists()
    assert empty.restore(backup) == latticed.Restored(1, 1, 0, 0, 0)
    there = empty.scene(scene.id)
    assert there.info.revision == 2
    np.testing.assert_array_equal(there.lattice().control_points, scene.lattice().control_points)
    with pytest.raises(latticed.LatticedError) as refused:
        empty.restore(backup)
    assert refused.value.code.name == "ALREADY_EXISTS" and scene.id in str(refused.value)
    assert empty.restore(backup, skip_existing=True) == latticed.Restored(0, 0, 1, 1, 0)


def test_latticectl_takes_its_file_and_it_takes_latticectls(client, scene, backup, empty):
    def latticectl(command, server, *more):
        subprocess.run(
            [LATTICECTL, command, backup, "--server", server, *more], check=True, capture_output=True
        )

    client.backup(backup, [scene.id])
    latticectl("restore", empty._connection.address)
    assert empty.scene(scene.id).info.revision == 2
    empty.scene(scene.id).delete()
    latticectl("backup", client._connection.address, "--scene", scene.id)
    assert empty.restore(backup).scenes == 1


def test_a_backup_that_fails_leaves_the_file_that_was_there(client, backup):
    backup.write_bytes(b"before")

    with pytest.raises(latticed.LatticedError, match="no-such-scene"):
        client.backup(backup, ["no-such-scene"])

    assert backup.read_bytes() == b"before"
    assert [path.name for path in backup.parent.iterdir()] == [backup.name]
    with pytest.raises(FileNotFoundError):
        client.backup(backup.parent / "no" / "folder")
    with pytest.raises(FileNotFoundError):
        client.restore(backup.parent / "no-file")


def test_a_file_that_is_not_what_was_written_is_refused_before_anything_is_sent(client, scene, backup, empty):
    client.backup(backup, [scene])
    whole = backup.read_bytes()
    seed = random.randrange(1 << 30)
    print(f"seed {seed}")
    source = random.Random(seed)

    def refused(data, why):
        backup.write_bytes(data)
        with pytest.raises(latticed.LatticedError, match=why) as error:
            empty.restore(backup)
        assert error.value.code.name == "DATA_LOSS" and "nothing was sent" in str(error.value)

    for _ in range(200):
        flipped = bytearray(whole)
        flipped[source.randrange(len(whole))] ^= 1 << source.randrange(8)
        refused(flipped, "server.backup")
        refused(whole[: source.randrange(len(whole))], "server.backup")
    refused(b"", "is no backup")
    refused(whole[:-1], "is cut off")
    refused(whole + b"x", "after its end")
    refused(whole[:16] + b"2" + whole[17:], "another version")
    refused(whole[:18] + b"\xff\xff\xff\xff" + whole[22:], "was changed")
    assert empty.scenes() == [] and empty.meshes() == []
