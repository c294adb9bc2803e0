# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Which encoding streams get whose view names none: by given rates, at servers that are old or slow, and at a real one."""
import logging
import time

import grpc
import latticed
import pytest
from latticed import draco, encoding_choice
from latticed.connection import Connection
from latticed.v1 import server_pb2, view_pb2

BOTH = [view_pb2.ENCODING_DRACO_POINTS, view_pb2.ENCODING_MESHOPT]


@pytest.fixture
def own(monkeypatch):
    """As if the package had its decoder, which is not called here."""
    monkeypatch.setattr(draco, "own_decoder", lambda: draco)


def server(probes, encodings, bytes_per_second):
    def probe(size):
        probes.append(size)
        time.sleep(size / bytes_per_second)
        return server_pb2.ServerInfo(encodings=encodings)

    return probe


def test_the_time_on_the_line_is_weighed_against_that_of_decoding():
    reason = "meshopt's 0.2 bytes more a point take 5.0 ns at 40 MB/s, decoding saves 6.0 ns"
    assert encoding_choice.choose_encoding(40e6) == ("meshopt", reason)
    assert encoding_choice.choose_encoding(25e6).encoding == "draco"


def test_a_slow_line_is_not_kept_busy_by_large_probes(own):
    probes = []
    assert encoding_choice.measured_choice(server(probes, BOTH, 1e5)).encoding == "draco"
    assert probes == [0, 0, 8192]


def test_without_meshopt_at_the_server_or_here_nothing_is_measured(own, monkeypatch):
    probes = []
    old = encoding_choice.measured_choice(server(probes, BOTH[:1], 1e9))
    assert old == ("draco", "the server has no meshopt")
    monkeypatch.setattr(draco, "own_decoder", lambda: None)
    undecoded = encoding_choice.measured_choice(server(probes, BOTH, 1e9))
    assert undecoded == ("draco", "this package was built without its decoder")
    assert probes == [0]


def test_streams_get_the_chosen_encoding_unless_the_view_or_the_scene_names_one(client, box, caplog):
    caplog.set_level(logging.INFO, "latticed")
    chosen = client.encoding_choice()
    with client.create_scene(box, delete_on_exit=True) as scene:
        with scene.watch() as stream:
            assert stream.latest.view.encoding == (chosen.encoding if draco.has_decoder() else "quantised")
        with scene.deform(latticed.View(encoding="raw")) as stream:
            assert stream.latest.view.encoding == "raw"
            stream.set_view(latticed.View(encoding="quantised"))
    with client.create_scene(box, view=latticed.View(encoding="raw"), delete_on_exit=True) as scene:
        with scene.deform() as stream:
            assert stream.latest.view.encoding == "raw"
    said = [record.message for record in caplog.records if record.message.startswith("points come by ")]
    assert said == [f"points come by {chosen.encoding} where no encoding is named: {chosen.reason}"]


def test_a_line_that_cannot_be_measured_gets_draco_and_is_measured_later(client, own, monkeypatch):
    def refuse(*_):
        raise latticed.LatticedError(grpc.StatusCode.UNAVAILABLE, "nobody is there")

    with monkeypatch.context() as patched:
        patched.setattr(Connection, "_probe", refuse)
        assert client.encoding_choice().encoding == "draco"
        assert "nobody is there" in client.encoding_choice().reason
    assert "decoding saves" in client.encoding_choice().reason
