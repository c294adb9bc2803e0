# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""When a call is made again, and after how long."""
import time
from typing import Callable, TypeVar

import grpc

from latticed.errors import LatticedError

# A proxy that cuts a call makes it CANCELLED, or UNKNOWN where it ends the stream without a status. A broken
# transport is INTERNAL.
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
    """Whether the same call may succeed if made again."""
    return error.code in _MAY_RETRY


def pause_after(failures: int) -> float:
    """The pause in seconds after the given number of failures in a row, from 1."""
    return _FIRST_PAUSE * float(2 ** (failures - 1))


def with_retries(call: Callable[[], Result]) -> Result:
    """Makes an idempotent call, four times in all, and turns what grpc raises into LatticedError."""
    failures = 0
    while True:
        try:
            return once(call)
        except LatticedError as error:
            failures += 1
            if failures == _ATTEMPTS or not may_retry(error):
                raise
        time.sleep(pause_after(failures))


def once(call: Callable[[], Result]) -> Result:
    """Makes a call and turns what grpc raises into LatticedError."""
    try:
        return call()
    except grpc.RpcError as error:
        raise LatticedError.from_rpc(error) from error
