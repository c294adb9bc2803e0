# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Turns the events of a stream into complete updates."""
from __future__ import annotations

from typing import Any, Dict, List, Optional

import numpy as np

from latticed.chunk import Chunk
from latticed.errors import LatticedError
from latticed.lattice import Lattice
from latticed.patches.lattice_history import LatticeHistory
from latticed.pattern import PatchPattern
from latticed.topology import Topology
from latticed.update import Update
from latticed.v1 import event_pb2, view_pb2
from latticed.view import View


class Surface:
    """The surface of a watcher. Only a complete update changes it. One thread at a time.

    Errors: LatticedError DATA_LOSS if events contradict each other.
    """

    def __init__(self) -> None:
        self._lattices = LatticeHistory()
        self._announced: Dict[str, Topology] = {}
        self._patterns: Dict[int, PatchPattern] = {}  # by code; they are the same on every stream
        self._quantisation: Any = None
        self._topology: Optional[Topology] = None
        self._chunks: List[Optional[Chunk]] = []
        self._begin: Any = None  # the update in progress: its update_begin, topology and chunks
        self._begun_topology: Optional[Topology] = None
        self._begun: Dict[int, Chunk] = {}

    @property
    def lattice(self) -> Optional[Lattice]:
        """The lattice after the newest reported edit."""
        return self._lattices.newest

    def apply(self, event: event_pb2.SceneEvent) -> Optional[Update]:
        """Takes one event. Returns an update if the event completes it."""
        arm = event.WhichOneof("event")
        if arm == "update_end":
            return self._take_end(event.update_end)
        if arm == "lattice_state":
            self._lattices.take_state(event.lattice_state)
        elif arm == "lattice_delta":
            self._lattices.take_delta(event.lattice_delta)
        elif arm == "topology":
            self._announced[event.topology.topology_id] = Topology(event.topology)
        elif arm == "patterns":
            for sent in event.patterns.patterns:
                pattern = PatchPattern(sent.points, sent.triangles, sent.denominator)
                self._patterns.setdefault(sent.code, pattern)
        elif arm == "quantisation":
            self._quantisation = event.quantisation
        elif arm == "update_begin":
            self.drop_partial_update()
            self._begin = event.update_begin
        elif arm == "chunks":
            self._take_chunks(event.chunks)
        return None  # the stream handles hello, results and heartbeats; later versions may add events

    def drop_partial_update(self) -> None:
        """Drops an update that has begun, because its stream has broken."""
        self._begin, self._begun_topology, self._begun = None, None, {}

    def _take_chunks(self, chunks: Any) -> None:
        if self._begin is None or self._begin.update_id != chunks.update_id:
            raise LatticedError.data_loss("chunks came outside of their update")
        quantisation = self._quantisation_of(chunks)
        held = self._topology is not None and self._topology.id == chunks.topology_id
        topology = self._topology if held else self._announced.get(chunks.topology_id)
        if topology is None:
            raise LatticedError.data_loss("chunks name a topology that was not sent")
        self._begun_topology = topology
        for chunk in chunks.chunks:
            if chunk.index >= topology.chunks:
                raise LatticedError.data_loss(f"chunk {chunk.index} of {topology.chunks}")
            self._begun[chunk.index] = Chunk(
                chunk.data,
                chunk.revision,
                quantisation,
                self._begin.view,
                self._patterns_of(chunk, topology),
            )

    def _quantisation_of(self, chunks: Any) -> Any:
        if self._begin.view.encoding == view_pb2.ENCODING_PATCHES:
            return event_pb2.Quantisation()  # such chunks have no positions
        if self._quantisation is None or self._quantisation.quantisation_id != chunks.quantisation_id:
            raise LatticedError.data_loss("chunks name a quantisation that was not sent")
        return self._quantisation

    def _patterns_of(self, chunk: Any, topology: Topology) -> List[PatchPattern]:
        if self._begin.view.encoding == view_pb2.ENCODING_PATCHES:
            return []  # they follow from the client's own tolerance
        patches = topology.patches_of(chunk.index)
        count = patches.stop - patches.start
        if topology.uniform is not None:
            return [topology.uniform] * count
        codes = np.frombuffer(chunk.levels, "<u2").tolist() if len(chunk.levels) == 2 * count else []
        if not codes or not all(code in self._patterns for code in codes):
            raise LatticedError.data_loss("a chunk's levels name no patterns that were sent")
        return [self._patterns[code] for code in codes]

    def _take_end(self, end: Any) -> Update:
        begin = self._begin
        if begin is None or begin.update_id != end.update_id:
            raise LatticedError.data_loss("update_end came without its update_begin")
        if len(self._begun) != begin.chunk_count:
            raise LatticedError.data_loss(
                f"an update of {begin.chunk_count} chunks ended after {len(self._begun)}"
            )
        if self._begun_topology is not None and self._begun_topology is not self._topology:
            self._topology, self._announced = self._begun_topology, {}
            self._chunks = [None] * self._topology.chunks
        self._chunks = [self._begun.get(i, chunk) for i, chunk in enumerate(self._chunks)]
        whole = [chunk for chunk in self._chunks if chunk is not None]
        if self._topology is None or len(whole) != self._topology.chunks:
            raise LatticedError.data_loss("an update ended before every chunk had come")
        self.drop_partial_update()
        lattice = self._lattices.at(end.revision)
        return Update(end, View.from_proto(begin.view), self._topology, whole, lattice)
