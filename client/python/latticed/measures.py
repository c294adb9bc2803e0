# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Measures of the exact deformed surface, and what edits keep."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Mapping, Optional, Sequence, Tuple

import numpy as np
import numpy.typing as npt

from latticed.choices import choose
from latticed.connection import Connection
from latticed.v1 import lattice_pb2, measure_pb2

FloatArray = npt.NDArray[np.float64]

MEASURES = {
    "volume": measure_pb2.MEASURE_VOLUME,
    "area": measure_pb2.MEASURE_AREA,
    "centroid": measure_pb2.MEASURE_CENTROID,
    "bounds": measure_pb2.MEASURE_BOUNDS,
}
_AXES = {
    "u": lattice_pb2.LATTICE_AXIS_U,
    "v": lattice_pb2.LATTICE_AXIS_V,
    "w": lattice_pb2.LATTICE_AXIS_W,
}
_NAMES = {number: name for name, number in _AXES.items()}


@dataclass(frozen=True)
class Measured:
    """What was not asked for is None.

    revision, structure_id  of the scene that was measured
    volume      enclosed, world units cubed; negative if the faces are oriented inwards
    area        world units squared, with an error of about area_error
    centroid    (3,): of the enclosed volume, world units
    bounds      (2, 3): the least and the greatest coordinates
    volume_gradient, area_gradient  (n, 3): d volume, d area / d control point, in the order of Lattice.indices
    centroid_gradient               (n, 3, 3): [p, i, j] is d centroid[j] / d coordinate i of control point p
    """

    revision: int
    structure_id: int
    volume: Optional[float]
    area: Optional[float]
    area_error: Optional[float]
    centroid: Optional[FloatArray]
    bounds: Optional[FloatArray]
    volume_gradient: Optional[FloatArray]
    area_gradient: Optional[FloatArray]
    centroid_gradient: Optional[FloatArray]


def measure(
    connection: Connection,
    scene: str,
    measures: Sequence[str],
    with_gradient: bool,
    area_tolerance: Optional[float],
    lattice: int,
) -> Measured:
    """Calls MeasureScene."""
    request = measure_pb2.MeasureSceneRequest(
        scene=scene,
        measures=[choose("a measure", name, MEASURES) for name in measures],
        with_gradient=with_gradient,
        area_tolerance=area_tolerance,
        lattice=lattice,
    )
    got = connection.call(connection.scenes.MeasureScene, request, scene)

    def triple(name: str) -> Optional[FloatArray]:
        return _numbers(getattr(got, name)) if got.HasField(name) else None

    def gradient(name: str, shape: Tuple[int, ...]) -> Optional[FloatArray]:
        flat = np.array(getattr(got, name), dtype=float)
        return flat.reshape(shape) if len(flat) else None

    least, greatest = triple("least"), triple("greatest")
    return Measured(
        got.revision,
        got.structure_id,
        got.volume if got.HasField("volume") else None,
        got.area if got.HasField("area") else None,
        got.area_error if got.HasField("area_error") else None,
        triple("centroid"),
        None if least is None or greatest is None else np.stack([least, greatest]),
        gradient("volume_gradient", (-1, 3)),
        gradient("area_gradient", (-1, 3)),
        gradient("centroid_gradient", (-1, 3, 3)),
    )


def _numbers(v: object) -> FloatArray:
    return np.array([getattr(v, "x"), getattr(v, "y"), getattr(v, "z")])


@dataclass(frozen=True)
class Constraints:
    """What edits keep. Every edit that moves control points honours it, also drag.

    held         indices of control points that no edit moves
    held_layers  by face, such as "u-" where u begins and "u+" where it ends: how many layers of control points
                 are held there. 1, 2, 3 layers join the inside to the identity with C0, C1, C2
    mirror       "u", "v" or "w": control points move as mirror images on this axis
    keep_volume  after every edit, free control points move by the least amount that restores the volume
    volume       which one, world units cubed; None: that of the mesh at rest
    volume_axis  moves them along one axis only
    """

    held: Tuple[int, ...] = ()
    held_layers: Mapping[str, int] = field(default_factory=dict)
    mirror: Optional[str] = None
    keep_volume: bool = False
    volume: Optional[float] = None
    volume_axis: Optional[str] = None

    def to_proto(self) -> lattice_pb2.Constraints:
        message = lattice_pb2.Constraints(held=self.held)
        for face, layers in self.held_layers.items():
            if face[1:] not in ("-", "+"):
                raise ValueError(f"a face is an axis with - or +, not {face!r}")
            axis = choose("an axis", face[:1], _AXES)
            message.held_layers.add(axis=axis, at_end=face[1:] == "+", layers=layers)
        if self.mirror is not None:
            message.mirror = choose("an axis", self.mirror, _AXES)
        if self.keep_volume:
            message.volume.SetInParent()
            if self.volume is not None:
                message.volume.volume = self.volume
            if self.volume_axis is not None:
                message.volume.axis = choose("an axis", self.volume_axis, _AXES)
        return message

    @staticmethod
    def from_proto(message: lattice_pb2.Constraints) -> Constraints:
        return Constraints(
            held=tuple(message.held),
            held_layers={
                _NAMES[item.axis] + ("+" if item.at_end else "-"): item.layers for item in message.held_layers
            },
            mirror=_NAMES.get(message.mirror),
            keep_volume=message.HasField("volume"),
            volume=message.volume.volume if message.volume.HasField("volume") else None,
            volume_axis=_NAMES.get(message.volume.axis),
        )
