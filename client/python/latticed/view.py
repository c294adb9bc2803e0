# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""A watcher's view of a scene."""
from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any, Callable, Dict

from latticed import draco
from latticed.choices import choose
from latticed.encoding_choice import EncodingChoice
from latticed.v1 import view_pb2

_ENCODINGS: Dict[str, Any] = {
    "": view_pb2.ENCODING_UNSPECIFIED,
    "draco": view_pb2.ENCODING_DRACO_POINTS,
    "draco_mesh": view_pb2.ENCODING_DRACO_MESH,
    "meshopt": view_pb2.ENCODING_MESHOPT,
    "raw": view_pb2.ENCODING_RAW,
    "quantised": view_pb2.ENCODING_QUANTISED,
    "patches": view_pb2.ENCODING_PATCHES,
}
NORMALS: Dict[str, Any] = {
    "": view_pb2.NORMAL_MODE_UNSPECIFIED,
    "none": view_pb2.NORMAL_MODE_NONE,
    "facet": view_pb2.NORMAL_MODE_FACET,
    "smooth": view_pb2.NORMAL_MODE_SMOOTH,
}


def _name(number: Any, numbers: Dict[str, Any]) -> str:
    return next((name for name, known in numbers.items() if known == number), "")


@dataclass(frozen=True)
class View:
    """A field of 0 or "" takes the scene's default view. The comments give the defaults of that view."""

    segments: int = (
        0  # subdivisions of a patch's edge, 1 to 32; default 10; with a tolerance, a limit of points
    )
    normals: str = ""  # "none", "facet" or "smooth"; default smooth if the mesh has normals, else facet
    # "draco", "draco_mesh", "meshopt", "raw" or "quantised"; default draco, in streams the faster of draco and meshopt. "patches": updates have no points, see PatchEvaluator
    encoding: str = ""
    position_bits: int = 0  # bits per coordinate, 8 to 16; default 12; no effect for raw
    normal_bits: int = 0  # bits per coordinate of the octahedral map, 6 to 12; default 8; no effect for raw
    max_points: int = 0  # most points of an update while edits come: the server lowers segments; 0: no limit
    max_bytes_per_second: int = 0  # most chunk bytes per second for this watcher; 0: no limit
    drag_position_bits: int = 0  # position_bits while any editor's gesture is open, 8 to 16; 0: position_bits
    drag_normal_bits: int = 0  # normal_bits while any editor's gesture is open, 6 to 12; 0: normal_bits
    # The largest distance of the triangles from the exact surface, in world units. Each patch then has points of
    # its own, and position_bits of 0 are chosen. 0 with segments set: every patch has these segments.
    tolerance: float = 0.0

    def to_proto(self) -> view_pb2.ViewOptions:
        """ValueError for an unknown name of encoding or normals."""
        named = {
            "normals": choose("normals", self.normals, NORMALS),
            "encoding": choose("encoding", self.encoding, _ENCODINGS),
        }
        return view_pb2.ViewOptions(**{**vars(self), **named})

    def for_stream(self, scene_default: View, choice: Callable[[], EncodingChoice]) -> view_pb2.ViewOptions:
        """Like for_watching; a view that names no encoding gets the one that `choice` names, instead of the scene's Draco."""
        if self.encoding or scene_default.encoding != "draco" or not draco.has_decoder():
            return self.for_watching(scene_default)
        return replace(self, encoding=choice().encoding).to_proto()

    def for_watching(self, scene_default: View) -> view_pb2.ViewOptions:
        """Like to_proto, with an encoding that can be decoded here. Without a decoder, a view that
        names no encoding gets QUANTISED instead of the scene's, and the logger "latticed" says it."""
        options = self.to_proto()
        wanted = self.encoding or scene_default.encoding
        has_decoder = draco.has_decoder() if wanted.startswith("draco") else draco.own_decoder() is not None
        if not wanted.startswith(("draco", "meshopt")) or has_decoder:
            return options
        if self.encoding:
            raise ValueError(
                f"encoding {self.encoding!r} needs a decoder: build the package with g++, python3-dev and libhwy-dev"
            )
        draco.say_that_it_is_missing()
        options.encoding = view_pb2.ENCODING_QUANTISED
        return options

    @classmethod
    def from_proto(cls, options: Any) -> View:
        """Converts a latticed.v1.ViewOptions."""
        values = {field.name: getattr(options, field.name) for field in fields(cls)}
        values["normals"] = _name(options.normals, NORMALS)
        values["encoding"] = _name(options.encoding, _ENCODINGS)
        return cls(**values)
