# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The lattice of a stream at its newest revisions."""
from __future__ import annotations

import dataclasses
from typing import Any, List, Optional

import numpy as np

from latticed.errors import LatticedError
from latticed.lattice import Lattice


class LatticeHistory:
    """Keeps all lattices since the newest complete update, because edits are reported before their update ends. Of a
    scene of several lattices, those of the first, or their sums. One thread at a time."""

    def __init__(self) -> None:
        self._lattices: List[Lattice] = []  # ascending by revision
        self._number = 0  # in the scene

    @property
    def newest(self) -> Optional[Lattice]:
        """The lattice after the newest reported edit; None before the first lattice_state."""
        return self._lattices[-1] if self._lattices else None

    def take_state(self, state: Any) -> None:
        """Takes a latticed.v1.LatticeState."""
        if state.index != next(iter(state.indexes), 0):
            return
        self._number = state.index
        lattice = Lattice.from_state(state)
        kept = [older for older in self._lattices if older.revision < lattice.revision]
        self._lattices = [*kept, lattice]

    def take_delta(self, delta: Any) -> None:
        """Takes a latticed.v1.LatticeDelta. DATA_LOSS if it contradicts the lattice."""
        old = self.newest
        if old is None or delta.structure_id != old.structure_id:
            return  # a lattice_state follows
        if delta.lattice != self._number:
            self._lattices.append(dataclasses.replace(old, revision=delta.revision))
            return
        indices = np.array(delta.indices, dtype=np.int64)
        if len(delta.positions) != 3 * len(indices):
            raise LatticedError.data_loss("a lattice_delta must have three numbers per index")
        points = old.control_points.reshape(-1, 3).copy()  # returned lattices must not change
        if indices.size and indices.max() >= len(points):
            raise LatticedError.data_loss("a lattice_delta names a control point that does not exist")
        points[indices] = np.array(delta.positions, dtype=float).reshape(-1, 3)
        shaped = points.reshape(old.control_points.shape)
        strength = delta.strength if delta.HasField("strength") else old.strength
        made = dataclasses.replace(old, control_points=shaped, revision=delta.revision, strength=strength)
        self._lattices.append(made)

    def at(self, revision: int) -> Optional[Lattice]:
        """The lattice at a revision, and forgets all older ones. If a lattice_state has skipped that revision, the
        oldest one after it."""
        while len(self._lattices) > 1 and self._lattices[0].revision < revision:
            self._lattices.pop(0)
        return self._lattices[0] if self._lattices else None
