# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""A chunk: the bytes of a run of patches as they were sent, and its points.

    position = origin + integer * step     QUANTISED, Draco and MESHOPT, in double
    position = origin + float32            RAW, added in double
    normal                                 the octahedral map of ENCODING_QUANTISED in view.proto

With ENCODING_PATCHES a chunk has no points: its bytes are edge bounds.
"""
from __future__ import annotations

import functools
from typing import Any, Dict, List, Sequence

import numpy as np
import numpy.typing as npt

from latticed import draco
from latticed.draco import Decoded
from latticed.errors import LatticedError
from latticed.pattern import PatchPattern
from latticed.v1 import view_pb2

_CODED = (view_pb2.ENCODING_DRACO_POINTS, view_pb2.ENCODING_DRACO_MESH, view_pb2.ENCODING_MESHOPT)


class Chunk:
    """Decoded once, at the first use. Updates share the chunks that did not change."""

    def __init__(
        self, data: bytes, revision: int, quantisation: Any, view: Any, patterns: Sequence[PatchPattern]
    ) -> None:
        self.data = data
        self.revision = revision  # at which its bytes or its patterns last changed
        self.patterns = patterns  # of its patches
        grid = quantisation.origin  # 0 0 0 if there is no grid
        self.origin = np.array([grid.x, grid.y, grid.z])
        self.step = float(quantisation.step)  # world units per integer; 0 for RAW
        self._position_bits = int(quantisation.bits)
        self._normal_bits = int(quantisation.normal_bits)
        self._encoding = view.encoding
        self._has_normals = view.normals != view_pb2.NORMAL_MODE_NONE
        self._points = sum(len(pattern) for pattern in patterns)

    @functools.cached_property
    def decoded(self) -> Decoded:
        """Positions relative to the origin, (points, 3), float32 for RAW and else float64; and unit normals,
        or None. The chunks of an update are decoded together. LatticedError DATA_LOSS for bytes that contradict the topology or the view.
        """
        if self._encoding == view_pb2.ENCODING_RAW:
            return self._raw()
        if self._encoding == view_pb2.ENCODING_QUANTISED:
            return self._quantised()
        if self._encoding in _CODED:
            decode_together([self])
            return self.decoded
        raise LatticedError.data_loss(
            f"the server sent encoding {self._encoding}, which this client does not know"
        )

    def _expect(self, count: int, due: int, what: str) -> None:
        if count != due:
            raise LatticedError.data_loss(f"a chunk holds {count} {what} instead of {due}")

    def _raw(self) -> Decoded:
        width = 6 if self._has_normals else 3
        self._expect(len(self.data), self._points * width * 4, "bytes")
        numbers = np.frombuffer(self.data, "<f4").reshape(-1, width)
        return numbers[:, :3], numbers[:, 3:] if self._has_normals else None

    def _quantised(self) -> Decoded:
        width = 0 if not self._has_normals else 1 if self._normal_bits <= 8 else 2
        self._expect(len(self.data), self._points * (6 + 2 * width), "bytes")
        integers = np.frombuffer(self.data, "<u2", 3 * self._points).reshape(3, -1).T
        positions = integers * self.step
        if not width:
            return positions, None
        st = np.frombuffer(self.data, f"<u{width}", offset=6 * self._points).reshape(2, -1)
        return positions, octahedral_normals(st[0], st[1], self._normal_bits).astype(np.float32)


def decode_together(chunks: Sequence[Chunk]) -> None:
    """Decodes those Draco and meshopt chunks that are not decoded yet: together it takes a fraction of the time. As Chunk.decoded."""
    groups: Dict[draco.Form, List[Chunk]] = {}
    for chunk in chunks:
        if chunk._encoding in _CODED and "decoded" not in vars(chunk):
            normal_bits = chunk._normal_bits if chunk._has_normals else 0
            is_meshopt = chunk._encoding == view_pb2.ENCODING_MESHOPT
            form = draco.Form(chunk._position_bits, normal_bits, chunk.step, is_meshopt)
            groups.setdefault(form, []).append(chunk)
    for form, group in groups.items():
        try:
            decoded = draco.decode([c.data for c in group], [c._points for c in group], form)
        except ValueError as error:
            raise LatticedError.data_loss(str(error)) from error
        for chunk, result in zip(group, decoded):
            vars(chunk)["decoded"] = result  # where cached_property keeps it


def octahedral_normals(s: npt.NDArray[Any], t: npt.NDArray[Any], bits: int) -> npt.NDArray[np.float64]:
    """Unit vectors (points, 3) by Draco's octahedral map; s and t are in 0 to 2^bits - 2."""
    top = float(2**bits - 2)
    y, z = 2.0 * s / top - 1.0, 2.0 * t / top - 1.0
    x = 1.0 - np.abs(y) - np.abs(z)
    fold = np.minimum(x, 0.0)
    y, z = y + np.where(y < 0, -fold, fold), z + np.where(z < 0, -fold, fold)
    vectors = np.stack([x, y, z], axis=-1)
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))
