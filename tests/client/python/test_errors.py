# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
import hashlib

import grpc
import latticed
import pytest
from google.protobuf import any_pb2, empty_pb2
from latticed import google_rpc

from server_process import ServerProcess


def packed(message):
    detail = any_pb2.Any()
    detail.Pack(message)
    return detail


def test_all_details_of_a_status_are_read():
    quota = google_rpc.QuotaFailure()
    quota.violations.add(subject="memory", description="asked 5 bytes, free 3 bytes")
    field = google_rpc.BadRequest()
    field.field_violations.add(field="edits[0].set_control_points", description="no")
    retry = google_rpc.RetryInfo()
    retry.retry_delay.FromMilliseconds(1500)
    ours = google_rpc.ErrorInfo(domain="latticed", reason="OUT_OF_MEMORY", metadata={"free_bytes": "3"})
    theirs = google_rpc.ErrorInfo(domain="proxy.example", reason="SOMETHING_ELSE")
    details = [packed(message) for message in (empty_pb2.Empty(), ours, quota, field, retry, theirs)]

    error = latticed.LatticedError.from_status(
        google_rpc.Status(code=8, message="full", details=details), "r1"
    )

    assert (error.code, error.reason) == (grpc.StatusCode.RESOURCE_EXHAUSTED, "OUT_OF_MEMORY")
    assert (error.field, error.retry_after, error.request_id) == ("edits[0].set_control_points", 1.5, "r1")
    assert error.metadata == {"free_bytes": "3", "quota": "memory: asked 5 bytes, free 3 bytes"}
    facts = "RESOURCE_EXHAUSTED, OUT_OF_MEMORY, field edits[0].set_control_points, request r1"
    assert str(error) == f"full ({facts})"


def test_a_code_of_a_later_version_is_unknown():
    assert latticed.LatticedError.from_status(google_rpc.Status(code=99)).code == grpc.StatusCode.UNKNOWN


def test_a_field_or_reason_that_is_said_already_is_not_said_again():
    error = latticed.LatticedError(
        grpc.StatusCode.NOT_FOUND, "fit.size: got 0", reason="NOT_FOUND", field="fit.size"
    )

    assert str(error) == "fit.size: got 0 (NOT_FOUND)"


def test_an_error_without_a_message_prints_its_code():
    assert str(latticed.LatticedError(grpc.StatusCode.INTERNAL, "")) == "(INTERNAL)"


@pytest.mark.parametrize("call", ["unary", "stream", "transfer"])
def test_an_unreachable_server_is_named_with_what_to_do(scene, call):
    address = "127.0.0.1:1"
    with latticed.connect(address, retry_for=0.3) as client:
        elsewhere = latticed.Scene(client._connection, scene.info)
        ask = {"unary": client.server_info, "stream": elsewhere.deform, "transfer": elsewhere.get_update}[
            call
        ]

        with pytest.raises(latticed.LatticedError) as caught:
            ask()

    assert str(caught.value).startswith(
        f"no answer from a server at {address}; start one with 'latticed', or name another in LATTICED_SERVER or "
    )
    assert "refused" in str(caught.value) and str(caught.value).endswith(" (UNAVAILABLE)")


def test_a_missing_token_says_where_to_put_one(tmp_path):
    tokens = tmp_path / "tokens"
    tokens.write_text(f"{hashlib.sha256(b'right').hexdigest()} edit tester\n")
    with ServerProcess("--token-file", tokens) as server:
        for token in ("", "wrong"):
            with latticed.connect(server.address, token=token) as client:
                with pytest.raises(latticed.LatticedError, match="LATTICED_TOKEN") as caught:
                    client.meshes()
            assert caught.value.code == grpc.StatusCode.UNAUTHENTICATED
            assert "LATTICED_TOKEN" not in caught.value.message  # the server's own words
