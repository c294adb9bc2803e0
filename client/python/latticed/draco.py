# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The decoder of the encodings "draco" and "draco_mesh": DracoPy, if it is installed."""
from __future__ import annotations

import functools
import logging
from typing import Any, Tuple

import numpy as np
import numpy.typing as npt

_LOG = logging.getLogger("latticed")
_NORMAL = 1  # DracoPy.AttributeType.NORMAL


@functools.lru_cache(maxsize=None)
def decoder() -> Any:
    """The module; None if it is missing, or older than 1.6 and cannot return normals of point clouds."""
    try:
        import DracoPy
    except ImportError:
        return None
    return DracoPy if hasattr(DracoPy.DracoPointCloud, "get_attribute_by_type") else None


@functools.lru_cache(maxsize=None)
def say_that_it_is_missing() -> None:
    """Logs it once per process. It is no warning, because the surface is the same and only takes more bytes."""
    _LOG.info(
        "no Draco decoder is installed (pip install DracoPy): the client requests QUANTISED, which is the same "
        "integers uncompressed"
    )


def decode(data: bytes) -> Tuple[npt.NDArray[np.float32], npt.NDArray[np.float32] | None]:
    """Positions relative to the origin, and unit normals or None, both (points, 3).

    ValueError for bytes that are no Draco chunk."""
    try:
        cloud = decoder().decode(data)
    except Exception as error:  # FileTypeException, TypeError or ValueError
        raise ValueError(f"DracoPy: {error}") from error
    normals = cloud.get_attribute_by_type(_NORMAL)
    return (
        np.asarray(cloud.points, dtype=np.float32).reshape(-1, 3),
        None if normals is None else np.asarray(normals["data"], dtype=np.float32).reshape(-1, 3),
    )
