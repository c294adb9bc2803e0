# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The arrays of PatchRun.data: unsigned integers in byte planes, one array after the other, in a zlib stream.

The lowest bytes of all numbers of an array come first, then the next bytes of all, and so on.
"""
from __future__ import annotations

import zlib

import numpy as np
import numpy.typing as npt

from latticed.errors import LatticedError

Integers = npt.NDArray[np.int64]


class BytePlanes:
    """Reads arrays in their order. LatticedError DATA_LOSS if the stream does not hold exactly these."""

    def __init__(self, data: bytes, size: int) -> None:
        """`size`: the bytes of all arrays together. No more are decompressed."""
        inflater = zlib.decompressobj()
        try:
            self._bytes = inflater.decompress(data, size + 1)
        except zlib.error as error:
            raise LatticedError.data_loss(f"a run of patches is no zlib stream: {error}") from error
        if len(self._bytes) != size or not inflater.eof or inflater.unused_data:
            raise LatticedError.data_loss(f"a run of patches does not hold the {size} bytes that it names")
        self._read = 0

    def take(self, count: int, width: int) -> Integers:
        """The next array: `count` numbers of `width` bytes."""
        end = self._read + count * width
        planes = np.frombuffer(self._bytes[self._read : end], np.uint8).reshape(width, count)
        self._read = end
        shifts = 8 * np.arange(width, dtype=np.int64)
        return np.asarray((planes.astype(np.int64) << shifts[:, None]).sum(axis=0))


def numbered(codes: Integers, begin: int, new: int, what: str) -> Integers:
    """Items numbered from 0 in the order of first use; `begin` of them came before.

    With h the number of items so far, code 0 is the new item h, and c > 0 is item h - c.
    DATA_LOSS unless `new` items are new and all others are known.
    """
    first = codes == 0
    so_far = begin + np.cumsum(first) - first
    items = np.where(first, so_far, so_far - codes)
    if int(first.sum()) != new or (items.size and items.min() < 0):
        raise LatticedError.data_loss(f"a run of patches uses {what} that it does not hold")
    return np.asarray(items, dtype=np.int64)


def differences_summed(codes: Integers) -> Integers:
    """The numbers whose differences are written: d as 2 d if d >= 0, else as -2 d - 1. Along the last axis."""
    differences = np.where(codes % 2 == 0, codes // 2, -(codes // 2) - 1)
    return np.asarray(np.cumsum(differences, axis=-1))
