# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""A set of points beside a scene."""
from __future__ import annotations

from typing import Any, Iterator, List, Optional, Sequence, Type

import numpy as np
import numpy.typing as npt

from latticed.connection import Connection
from latticed.errors import LatticedError
from latticed.points.values import FloatArray, PointGradients, PointValues
from latticed.retries import once, with_retries
from latticed.upload import PART_BYTES
from latticed.v1 import points_pb2

_MOST_DIRECTIONS = 64  # of one call
_VECTOR_BYTES = 24


def parts(data: npt.NDArray[Any]) -> Iterator[bytes]:
    """The bytes of an array, little-endian, in messages that the server takes."""
    view = np.ascontiguousarray(data).data.cast("B")
    for begin in range(0, len(view), PART_BYTES):
        yield bytes(view[begin : begin + PART_BYTES])


def vectors(numbers: npt.ArrayLike, what: str) -> npt.NDArray[np.float64]:
    """Numbers as doubles; the last axis is x, y, z."""
    array: npt.NDArray[np.float64] = np.asarray(numbers, dtype="<f8")
    if array.ndim < 2 or array.shape[-1] != 3:
        raise ValueError(f"{what}: x, y and z of each are needed, not the shape {array.shape}")
    return array


class PointSet:
    """Made by Scene.points, surface_points or view_points. Any number of threads may use it.

    The points are sorted on the server once. They stay there until delete(), the end of the `with` block, or the end of
    the scene; after a restart of the server they are gone, and calls fail with NOT_FOUND. Points outside the lattice's
    frame stay where they are.
    """

    def __init__(self, connection: Connection, info: Any) -> None:
        self._connection = connection
        self._stub = connection.points
        self.info = info  # latticed.v1.PointSet, described in points.proto, as received when it was made

    def __repr__(self) -> str:
        return f"<PointSet {self.id}: {len(self)} points of scene {self.info.scene}>"

    def __len__(self) -> int:
        return int(self.info.points)

    @property
    def id(self) -> str:
        return str(self.info.id)

    @property
    def has_normals(self) -> bool:
        return bool(self.info.has_normals)

    def deform(self, normals: bool = False, revision: int = 0) -> PointValues:
        """The deformed points, and their normals if these are asked for.

        revision  fails with REVISION_CHANGED unless this is the newest revision; 0: the newest
        """
        request = points_pb2.DeformPointSetRequest(
            scene=self.info.scene, point_set=self.id, with_normals=normals, revision=revision
        )
        values = self._read(self._stub.DeformPointSet, request)
        return PointValues(
            values.positions[0],
            None if values.normals is None else values.normals[0],
            values.revision,
            values.structure_id,
        )

    def jvp(
        self,
        tangents: npt.ArrayLike,
        indices: Optional[Sequence[int]] = None,
        normals: bool = False,
        revision: int = 0,
        lattice: int = 0,
    ) -> PointValues:
        """Forward mode: how the deformed points move when the control points move by `tangents`, to first order.

        tangents  (control points, 3), or shaped like Lattice.control_points; with one more axis in front, several
                  directions at once
        indices   the control points that move, and that `tangents` has; None: all
        normals, revision  as in deform
        lattice   whose control points move, from 0, where the scene has several
        """
        array = vectors(tangents, "tangents")
        several = array.ndim in (3, 5)
        directions = array.reshape(len(array), -1, 3) if several else array.reshape(1, -1, 3)
        each = self._together(directions.shape[1])
        made: List[PointValues] = []
        for begin in range(0, len(directions), each):
            request = points_pb2.ApplyJacobianRequest(
                scene=self.info.scene,
                point_set=self.id,
                with_normals=normals,
                revision=made[0].revision if made else revision,
                indices=indices,
                tangents=directions[begin : begin + each].tobytes(),
                lattice=lattice,
            )
            made.append(self._read(self._stub.ApplyJacobian, request))
        positions = np.concatenate([values.positions for values in made])
        carried = np.concatenate([v.normals for v in made if v.normals is not None]) if normals else None
        if not several:
            positions, carried = positions[0], None if carried is None else carried[0]
        return PointValues(positions, carried, made[0].revision, made[0].structure_id)

    def vjp(
        self,
        cotangents: npt.ArrayLike,
        normals: Optional[npt.ArrayLike] = None,
        revision: int = 0,
        lattice: int = 0,
    ) -> PointGradients:
        """Reverse mode: the derivative by all control points of a value whose derivative by the deformed points is
        `cotangents`. The same call at the same revision returns the same bits.

        cotangents  (n, 3), or (N, n, 3) for N values at once
        normals     the derivative of the value by the normals, of the same shape; None: it does not depend on them
        revision    as in deform
        lattice     by whose control points, from 0, where the scene has several
        """
        array = vectors(cotangents, "cotangents")
        several = array.ndim == 3
        blocks = [array if several else array[None]]
        if normals is not None:
            by_normals = vectors(normals, "normals")
            blocks.append(by_normals if several else by_normals[None])
        for block in blocks:
            if block.shape != (len(blocks[0]), len(self), 3):
                raise ValueError(f"cotangents of {len(self)} points are needed, not the shape {block.shape}")
        data = np.concatenate(blocks, axis=1)
        header = points_pb2.CotangentHeader(
            scene=self.info.scene,
            point_set=self.id,
            with_normals=normals is not None,
            revision=revision,
            lattice=lattice,
        )
        made: List[PointGradients] = []
        # How many directions one call may have depends on the lattice, which the first answer shows.
        begin = 0
        while begin < len(data):
            each = self._together(made[0].gradients.shape[1]) if made else 1
            header.directions = len(data[begin : begin + each])
            made.append(self._gradients(header, data[begin : begin + each]))
            header.revision = made[0].revision
            begin += each
        gradients = np.concatenate([part.gradients for part in made])
        return PointGradients(gradients if several else gradients[0], made[0].revision, made[0].structure_id)

    def delete(self) -> None:
        """Frees the memory on the server."""
        request = points_pb2.DeletePointSetRequest(scene=self.info.scene, point_set=self.id)
        self._connection.call_once(self._stub.DeletePointSet, request, self.info.scene)

    def __enter__(self) -> PointSet:
        return self

    def __exit__(self, kind: Type[BaseException] | None, *error: object) -> None:
        try:
            self.delete()
        except LatticedError as failure:
            if kind is None and failure.reason != "NOT_FOUND":  # an exception of the block comes first
                raise

    @staticmethod
    def _together(control_points: int) -> int:
        return max(1, min(_MOST_DIRECTIONS, PART_BYTES // (_VECTOR_BYTES * max(1, control_points))))

    def _read(self, method: Any, request: Any) -> PointValues:
        """All directions: positions and normals are (N, n, 3)."""

        def attempt() -> PointValues:
            call = method(request, metadata=self._connection.metadata(self.info.scene))
            try:
                header = next(call).header
                n = header.points
                values = np.empty((header.directions, 2 if header.with_normals else 1, n, 3), dtype="<f8")
                bytes_of, at = values.data.cast("B"), 0
                for message in call:
                    bytes_of[at : at + len(message.data)] = message.data
                    at += len(message.data)
            except StopIteration:
                raise LatticedError.data_loss("the server sent no points") from None
            finally:
                call.cancel()
            if at != values.nbytes:
                raise LatticedError.data_loss(f"{at} of {values.nbytes} bytes of points came")
            normals = values[:, 1] if header.with_normals else None
            return PointValues(values[:, 0], normals, header.revision, header.structure_id)

        return with_retries(self._connection.reachability, attempt)

    def _gradients(self, header: Any, data: FloatArray) -> PointGradients:
        def messages() -> Iterator[points_pb2.ApplyJacobianTransposeRequest]:
            yield points_pb2.ApplyJacobianTransposeRequest(header=header)
            for part in parts(data):
                yield points_pb2.ApplyJacobianTransposeRequest(data=part)

        metadata = self._connection.metadata(self.info.scene)
        answer = with_retries(
            self._connection.reachability,
            lambda: self._stub.ApplyJacobianTranspose(messages(), metadata=metadata),
        )
        gradients = np.frombuffer(answer.gradients, dtype="<f8").reshape(len(data), -1, 3)
        return PointGradients(gradients, answer.revision, answer.structure_id)


def create(connection: Connection, header: points_pb2.PointSetHeader, data: Sequence[Any]) -> PointSet:
    """Creates a set from its header and the arrays whose bytes follow."""

    def messages() -> Iterator[points_pb2.CreatePointSetRequest]:
        yield points_pb2.CreatePointSetRequest(header=header)
        for array in data:
            for part in parts(array):
                yield points_pb2.CreatePointSetRequest(data=part)

    # A second attempt would leave the first one's set behind, if only its answer was lost; so it is made once.
    metadata = connection.metadata(header.scene)
    info = once(connection.address, lambda: connection.points.CreatePointSet(messages(), metadata=metadata))
    return PointSet(connection, info)
