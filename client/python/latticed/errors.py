# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The exception that this package raises for errors of a server."""
from __future__ import annotations

from typing import Any, Dict

import grpc

from latticed.google_rpc import BadRequest, ErrorInfo, QuotaFailure, RetryInfo, Status

_DOMAIN = "latticed"
_DETAILS = "grpc-status-details-bin"
_REQUEST_ID = "latticed-request-id"
_HINTS = {grpc.StatusCode.UNAUTHENTICATED: "pass a token to latticed.connect, or set LATTICED_TOKEN"}
_CODES = {code.value[0]: code for code in grpc.StatusCode}


class LatticedError(Exception):
    """Why a call failed, or an edit was refused.

    code         the status, for example grpc.StatusCode.NOT_FOUND
    reason       a name of ErrorReason without its prefix, for example "STRUCTURE_CHANGED"; may be empty
    field        path of the wrong field in the request; may be empty
    metadata     ids and numbers in the message
    retry_after  seconds to wait before another attempt; 0: the server does not say
    request_id   the request's id in the server's log; empty if no server answered

    It prints as the message, a hint where there is one, and the rest in parentheses:
    no scene with id 'x' (NOT_FOUND, request 576c9c552daaf621)
    """

    def __init__(
        self,
        code: grpc.StatusCode,
        message: str,
        reason: str = "",
        field: str = "",
        metadata: Dict[str, str] | None = None,
        retry_after: float = 0.0,
        request_id: str = "",
    ) -> None:
        self.code = code
        self.message = message
        self.reason = reason
        self.field = field
        self.metadata = dict(metadata or {})
        self.retry_after = retry_after
        self.request_id = request_id
        facts = [code.name]
        if reason and reason != code.name:
            facts.append(reason)
        if field and field not in message:
            facts.append(f"field {field}")
        if request_id:
            facts.append(f"request {request_id}")
        sentences = "; ".join(filter(None, (message, _HINTS.get(code))))
        super().__init__(f"{sentences} ({', '.join(facts)})".lstrip())

    @classmethod
    def from_status(cls, status: Any, request_id: str = "") -> LatticedError:
        """Converts a google.rpc.Status, for example EditResult.status."""
        details: Dict[str, Any] = {"metadata": {}}
        for packed in status.details:
            info, bad, retry, quota = ErrorInfo(), BadRequest(), RetryInfo(), QuotaFailure()
            if packed.Unpack(info) and info.domain == _DOMAIN:
                details["reason"] = info.reason
                details["metadata"].update(info.metadata)
            elif packed.Unpack(bad) and bad.field_violations:
                details["field"] = bad.field_violations[0].field
            elif packed.Unpack(retry):
                details["retry_after"] = retry.retry_delay.seconds + 1e-9 * retry.retry_delay.nanos
            elif packed.Unpack(quota):
                details["metadata"]["quota"] = "; ".join(
                    f"{v.subject}: {v.description}" for v in quota.violations
                )
        code = _CODES.get(status.code, grpc.StatusCode.UNKNOWN)
        return cls(code, status.message, request_id=request_id, **details)

    @classmethod
    def from_rpc(cls, error: Any, address: str) -> LatticedError:
        """Converts the grpc.RpcError that a call to the server at this address raised."""
        trailers = dict(error.trailing_metadata() or ())
        status = Status()
        if _DETAILS in trailers:
            status.ParseFromString(trailers[_DETAILS])
        status.code, status.message = error.code().value[0], error.details() or ""
        # A latticed server puts the request's id into every answer.
        if error.code() == grpc.StatusCode.UNAVAILABLE and _REQUEST_ID not in trailers:
            status.message = (
                f"no answer from a server at {address}; start one with 'latticed', or name another in "
                f"LATTICED_SERVER or latticed.connect. gRPC says: {status.message}"
            )
        return cls.from_status(status, str(trailers.get(_REQUEST_ID, "")))

    @classmethod
    def data_loss(cls, message: str) -> LatticedError:
        """An error for messages of the server that contradict each other: the stream cannot be trusted."""
        return cls(grpc.StatusCode.DATA_LOSS, message)
