# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""How constraints change what an edit of control points does, and so its derivative."""
from __future__ import annotations

from typing import Optional, Tuple

import numpy as np
import numpy.typing as npt

from latticed.lattice import FloatArray, Lattice
from latticed.measures import Constraints
from latticed.scene import Scene

_AXES = "uvw"


class PointFreedom:
    """Where control points come to lie when one edit sets some of them, by held points and layers, and the mirror.

    The map is linear, and the same at all control points: a held point stays; where one of a pair is set, the other goes
    to its image; where both are set, they go half-way to each other's images (core/ffd/constraints/point_freedom.h).
    A kept volume has no such map: ValueError.
    """

    def __init__(self, lattice: Lattice, constraints: Constraints) -> None:
        if constraints.keep_volume:
            raise ValueError(
                "the lattice keeps the volume (Scene.set_constraints), and the derivative of the moves that restore it is "
                "not known: take keep_volume out, and give the volume to the optimiser, as "
                "latticed.scipy.Shape.kept_volume or by the gradient of Scene.measure"
            )
        indices = lattice.indices
        held = np.zeros(indices.shape, dtype=bool)
        held.reshape(-1)[list(constraints.held)] = True
        for face, layers in constraints.held_layers.items():
            along = np.moveaxis(held, 2 - _AXES.index(face[0]), 0)  # a view: w comes first
            along[slice(-layers, None) if face[1] == "+" else slice(layers)] = True
        self._images: Optional[npt.NDArray[np.int64]] = None
        if constraints.mirror is not None:
            axis = _AXES.index(constraints.mirror)
            self._images = np.flip(indices, 2 - axis).reshape(-1)
            self._normal: FloatArray = lattice.edges[axis] / np.linalg.norm(lattice.edges[axis])
            held |= np.flip(held, 2 - axis)
        self._held = held.reshape(-1)

    def pull_back(self, gradients: FloatArray, named: npt.NDArray[np.int64]) -> FloatArray:
        """The derivative by the positions that an edit sets, (m, 3), of a value whose derivative by all control points, as
        they lie after it, is `gradients`, (n, 3). named: the indices that the edit sets, (m,), none twice."""
        free = np.where(self._held[:, None], 0, gradients)
        if self._images is None:
            return free[named]
        seen = free[self._images]
        both = free + seen - 2 * (seen @ self._normal)[:, None] * self._normal
        is_named = np.zeros(len(free), dtype=bool)
        is_named[named] = True
        half_way = is_named[self._images[named]]
        return np.where(half_way[:, None], 0.5, 1) * both[named]


def lattice_and_freedom(scene: Scene, number: int) -> Tuple[Lattice, PointFreedom]:
    """A lattice of a scene at the newest revision, and how its control points may move."""
    state = scene._lattice_state(number)
    lattice = Lattice.from_state(state)
    return lattice, PointFreedom(lattice, Constraints.from_proto(state.constraints))
