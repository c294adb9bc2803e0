# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Which encoding of points suits the line to a server, where nobody has chosen one (client/README.md, "Encodings")."""
from __future__ import annotations

import time
from typing import Any, Callable, NamedTuple

from latticed import draco
from latticed.v1 import view_pb2

_MORE_BYTES = 0.2  # of a point by meshopt
# What a point of meshopt takes less than one of Draco to decode: 3.4 and 9.1 ns in C++ on a virtual CPU with AVX-512.
_SAVED_NS = 6.0
# The first probe fits what TCP sends at once. If it takes so long, the line is slow, and larger ones would keep it busy.
_SMALL_PROBE, _LARGE_PROBE = 8 << 10, 256 << 10
_SLOW_SECONDS = 0.01


class EncodingChoice(NamedTuple):
    encoding: str  # "draco" or "meshopt"
    reason: str  # for people


def choose_encoding(line_rate: float) -> EncodingChoice:
    """line_rate: bytes a second."""
    extra_ns = 1e9 * _MORE_BYTES / line_rate
    return EncodingChoice(
        "meshopt" if extra_ns < _SAVED_NS else "draco",
        f"meshopt's {_MORE_BYTES} bytes more a point take {extra_ns:.1f} ns at {line_rate / 1e6:.4g} MB/s, "
        f"decoding saves {_SAVED_NS:.1f} ns",
    )


def measured_choice(probe: Callable[[int], Any]) -> EncodingChoice:
    """By the rate of the line. probe(bytes) asks for a ServerInfo with a probe of so many bytes."""
    if draco.own_decoder() is None:
        return EncodingChoice("draco", "this package was built without its decoder")
    if view_pb2.ENCODING_MESHOPT not in probe(0).encodings:  # connects, too
        return EncodingChoice("draco", "the server has no meshopt")
    return choose_encoding(_line_rate(probe))


def _line_rate(probe: Callable[[int], Any]) -> float:
    """Bytes a second. The last of two large probes counts: TCP's windows have grown by then."""

    def timed(size: int) -> float:
        begin = time.monotonic()
        probe(size)
        return time.monotonic() - begin

    round_trip = timed(0)
    size, seconds = _SMALL_PROBE, timed(_SMALL_PROBE)
    if seconds - round_trip <= _SLOW_SECONDS:
        timed(_LARGE_PROBE)
        size, seconds = _LARGE_PROBE, timed(_LARGE_PROBE)
    return size / max(seconds - round_trip, seconds / 10)
