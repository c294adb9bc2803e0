# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Decodes the encodings "draco", "draco_mesh" and "meshopt": by the package's own decoder where it was built, else by DracoPy
where that is installed. Draco streams of another writer go to DracoPy; "meshopt" needs the package's own."""
from __future__ import annotations

import functools
import logging
from typing import Any, List, NamedTuple, Sequence, Tuple

import numpy as np
import numpy.typing as npt

_LOG = logging.getLogger("latticed")
_NORMAL = 1  # DracoPy.AttributeType.NORMAL

Decoded = Tuple[npt.NDArray[np.floating[Any]], "npt.NDArray[np.float32] | None"]


class Form(NamedTuple):
    """What chunks that are decoded together have in common."""

    position_bits: int
    normal_bits: int  # 0: no normals
    step: float
    is_meshopt: bool = False


def own_decoder() -> Any:
    """The module of client/python/decoder_module.cc; None if the package was built without a compiler."""
    try:
        from latticed import _decoder
    except ImportError:
        return None
    return _decoder


@functools.lru_cache(maxsize=None)
def draco_py() -> Any:
    """The module; None if it is missing, or older than 1.6 and cannot return normals of point clouds."""
    try:
        import DracoPy
    except ImportError:
        return None
    return DracoPy if hasattr(DracoPy.DracoPointCloud, "get_attribute_by_type") else None


def has_decoder() -> bool:
    return own_decoder() is not None or draco_py() is not None


@functools.lru_cache(maxsize=None)
def say_that_it_is_missing() -> None:
    """Logs it once per process. It is no warning, because the surface is the same and only takes more bytes."""
    _LOG.info(
        "this package was built without its decoder, which needs g++, python3-dev and libhwy-dev: the client requests "
        "QUANTISED, which is the same integers uncompressed"
    )


def decode(streams: Sequence[bytes], points: Sequence[int], form: Form) -> List[Decoded]:
    """For each chunk its positions relative to the origin, and unit normals or None, both (points, 3).

    ValueError for bytes that are no chunk of the form, or have another number of points or normals."""
    ours: List[Decoded | None] = _by_own(streams, points, form) or [None] * len(streams)
    return [
        _by_stock(stream, count, form) if decoded is None else decoded
        for stream, count, decoded in zip(streams, points, ours)
    ]


def _by_own(streams: Sequence[bytes], points: Sequence[int], form: Form) -> List[Decoded | None] | None:
    """None for each chunk that is not as latticed writes it; None alone without the decoder."""
    own = own_decoder()
    if own is None:
        return None
    positions = tuple(np.empty((count, 3)) for count in points)
    normals = tuple(np.empty((count, 3), np.float32) for count in points if form.normal_bits)
    good = own.decode(
        tuple(streams), form.is_meshopt, form.position_bits, form.normal_bits, form.step, positions, normals
    )
    arrays = zip(positions, normals or [None] * len(positions))
    return [decoded if is_good else None for decoded, is_good in zip(arrays, good)]


def _by_stock(stream: bytes, points: int, form: Form) -> Decoded:
    if form.is_meshopt:
        raise ValueError("a chunk is no meshopt stream of its view")
    return _by_draco_py(stream, points, form)


def _by_draco_py(stream: bytes, points: int, form: Form) -> Decoded:
    module = draco_py()
    if module is None:
        raise ValueError("a chunk is no Draco stream of latticed; pip install DracoPy decodes any other")
    try:
        cloud = module.decode(stream)
    except Exception as error:  # FileTypeException, TypeError or ValueError
        raise ValueError(f"DracoPy: {error}") from error
    floats = np.asarray(cloud.points, dtype=np.float32).reshape(-1, 3)
    if len(floats) != points:
        raise ValueError(f"a chunk holds {len(floats)} points instead of {points}")
    # The decoder's floats are rounded multiples of the step; this restores the exact ones.
    positions = np.rint(floats.astype(float) / form.step) * form.step
    if not form.normal_bits:
        return positions, None
    sent = cloud.get_attribute_by_type(_NORMAL)
    normals = np.asarray([] if sent is None else sent["data"], dtype=np.float32).reshape(-1, 3)
    if len(normals) != points:
        raise ValueError(f"a chunk holds {len(normals)} normals instead of {points}")
    return positions, normals
