# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
import grpc
import latticed
from google.protobuf import any_pb2, empty_pb2
from latticed import google_rpc


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
    assert str(error).endswith("OUT_OF_MEMORY: full (field edits[0].set_control_points) (request r1)")


def test_a_code_of_a_later_version_is_unknown():
    assert latticed.LatticedError.from_status(google_rpc.Status(code=99)).code == grpc.StatusCode.UNKNOWN
