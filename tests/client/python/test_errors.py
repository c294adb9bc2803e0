# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
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
    assert (
        str(error)
        == "RESOURCE_EXHAUSTED, OUT_OF_MEMORY: full (field edits[0].set_control_points) (request r1)"
    )


def test_a_code_of_a_later_version_is_unknown():
    assert latticed.LatticedError.from_status(google_rpc.Status(code=99)).code == grpc.StatusCode.UNKNOWN


def test_a_server_without_memory_says_how_much_there_is():
    with ServerProcess("--memory", "2MiB") as server, latticed.connect(server.address) as client:
        with pytest.raises(latticed.LatticedError) as caught:
            client.upload_arrays([[0.0, 0, 0]] * 100000, [[0, 1, 2]], progress=False)

    assert caught.value.reason == "OUT_OF_MEMORY"
    assert int(caught.value.metadata["asked_bytes"]) > int(caught.value.metadata["free_bytes"])
