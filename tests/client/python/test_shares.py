# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Shares of scenes, through a server with tokens."""
import hashlib
from datetime import datetime, timedelta, timezone

import pytest

import latticed
from server_process import ServerProcess


@pytest.fixture
def server(tmp_path):
    tokens = tmp_path / "tokens"
    tokens.write_text(f"{hashlib.sha256(b'right').hexdigest()} edit tester\n")
    with ServerProcess("--token-file", tokens) as process:
        yield process


@pytest.fixture
def scene(server, tmp_path):
    mesh = tmp_path / "square.obj"
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
    with latticed.connect(server.address, token="right") as client:
        yield client.create_scene(client.upload(mesh))


def test_a_share_opens_its_scene_until_it_is_revoked(server, scene):
    before = datetime.now(timezone.utc)
    share = scene.share("edit", timedelta(hours=2))
    assert timedelta(hours=1.9) < share.expires - before < timedelta(hours=2.1)
    assert (share.role, share.creator) == ("edit", "tester")
    assert scene.shares() == [share] and share.token not in repr(share)

    with latticed.connect(server.address, token=share.token) as guest:
        shared = guest.scene(scene.id)
        result = shared.move(shared.lattice().indices[-1], (0.5, 0, 0))
        assert result.revision == 1
        with pytest.raises(latticed.LatticedError) as refused:
            guest.scenes()
        assert refused.value.reason == "PERMISSION_DENIED"

        assert [listed.id for listed in scene.shares()] == [share.id]
        assert scene.shares()[0].token == ""
        scene.revoke(share)
        assert scene.shares() == []
        with pytest.raises(latticed.LatticedError, match="revoked"):
            shared.refresh()


def test_a_reader_does_not_edit(server, scene):
    with latticed.connect(server.address, token=scene.share().token) as guest:
        shared = guest.scene(scene.id)
        assert shared.get_update().revision == 0
        with pytest.raises(latticed.LatticedError) as refused:
            shared.move(shared.lattice().indices[-1], (0.5, 0, 0))
        assert refused.value.reason == "PERMISSION_DENIED"


def test_a_wrong_role_names_the_right_ones(scene):
    with pytest.raises(ValueError, match="read"):
        scene.share("admin")
