# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""After which errors a call is made again, and after which pause."""
import time
from typing import Callable, TypeVar

import grpc

from latticed.errors import LatticedError

# If a proxy cuts a call, gRPC reports CANCELLED, or UNKNOWN if the stream ends without a status. For a broken
# transport it reports INTERNAL.
_MAY_RETRY = (
    grpc.StatusCode.CANCELLED,
    grpc.StatusCode.INTERNAL,
    grpc.StatusCode.UNAVAILABLE,
    grpc.StatusCode.UNKNOWN,
)
_ATTEMPTS = 4
_FIRST_PAUSE = 0.1

Result = TypeVar("Result")


def may_retry(error: LatticedError) -> bool:
    """Whether another attempt at the call may succeed."""
    return error.code in _MAY_RETRY


def pause_after(failures: int) -> float:
    """The pause in seconds after the given number of failures in a row, 1 or more."""
    return _FIRST_PAUSE * float(2 ** (failures - 1))


def with_retries(address: str, call: Callable[[], Result]) -> Result:
    """Makes an idempotent call to the server at an address, with up to four attempts. Converts grpc.RpcError
    to LatticedError."""
    failures = 0
    while True:
        try:
            return once(address, call)
        except LatticedError as error:
            failures += 1
            if failures == _ATTEMPTS or not may_retry(error):
                raise
        time.sleep(pause_after(failures))


def once(address: str, call: Callable[[], Result]) -> Result:
    """Makes a call to the server at an address. Converts grpc.RpcError to LatticedError."""
    try:
        return call()
    except grpc.RpcError as error:
        raise LatticedError.from_rpc(error, address) from error
