# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""google.rpc, the messages of error details.

protobuf refuses two copies of a message in one process. This module uses googleapis-common-protos if it is
installed, and otherwise, as on Debian, the copies in this package.
"""
from pathlib import Path

import google

try:
    from google.rpc import error_details_pb2, status_pb2
except ImportError:
    google.__path__.append(str(Path(__file__).with_name("googleapis") / "google"))
    from google.rpc import error_details_pb2, status_pb2

if hasattr(error_details_pb2, "ErrorInfo"):
    ErrorInfo = error_details_pb2.ErrorInfo
else:  # Debian's error_details.proto is older than the message
    from google.rpc import error_info_pb2

    ErrorInfo = error_info_pb2.ErrorInfo
BadRequest = error_details_pb2.BadRequest
QuotaFailure = error_details_pb2.QuotaFailure
RetryInfo = error_details_pb2.RetryInfo
Status = status_pb2.Status

__all__ = ["BadRequest", "ErrorInfo", "QuotaFailure", "RetryInfo", "Status"]
