# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Turns the events of a stream into complete updates."""
from __future__ import annotations

from typing import Any, Dict, List, Optional, Tuple

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
        self._sums = LatticeHistory()  # of several lattices, with ENCODING_PATCHES
        self._begun_sum = False  # whether the update in progress has one
        self._announced: Dict[str, Topology] = {}
        self._patterns: Dict[int, PatchPattern] = {}  # by code; they are the same on every stream
        self._quantisation: Any = None
        self._topology: Optional[Topology] = None
        self._chunks: List[Optional[Chunk]] = []
        self._begin: Any = None  # the update in progress: its update_begin, topology and chunks
        self._begun_topology: Optional[Topology] = None
        self._begun: Dict[int, Chunk] = {}
        self._bounds = bytearray()  # of all edges, with ENCODING_PATCHES; chunks have no data then
        self._begun_bounds: List[Tuple[int, bytes]] = []  # the first edge, and the bounds from there on

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
        elif arm == "patch_lattice":
            self._take_sum(event.patch_lattice)
        elif arm == "chunks":
            self._take_chunks(event.chunks)
        return None  # the stream handles hello, results and heartbeats; later versions may add events

    def drop_partial_update(self) -> None:
        """Drops an update that has begun, because its stream has broken."""
        self._begin, self._begun_topology, self._begun, self._begun_bounds = None, None, {}, []
        self._begun_sum = False

    def _take_sum(self, news: Any) -> None:
        if self._begin is None:
            raise LatticedError.data_loss("a patch_lattice came outside of an update")
        self._begun_sum = True
        if news.HasField("delta"):
            self._sums.take_delta(news.delta)
        else:
            self._sums.take_state(news.state)

    def _take_chunks(self, chunks: Any) -> None:
        if self._begin is None or self._begin.update_id != chunks.update_id:
            raise LatticedError.data_loss("chunks came outside of their update")
        quantisation = self._quantisation_of(chunks)
        is_known = self._topology is not None and self._topology.id == chunks.topology_id
        topology = self._topology if is_known else self._announced.get(chunks.topology_id)
        if topology is None:
            raise LatticedError.data_loss("chunks name a topology that was not sent")
        self._begun_topology = topology
        for chunk in chunks.chunks:
            end = chunk.index + max(chunk.chunk_count, 1)
            if end > topology.chunks:
                raise LatticedError.data_loss(f"chunk {end - 1} of {topology.chunks}")
            data = chunk.data
            if self._begin.view.encoding == view_pb2.ENCODING_PATCHES:
                data = self._take_bounds(chunk, topology)
            held = Chunk(
                data, chunk.revision, quantisation, self._begin.view, self._patterns_of(chunk, topology)
            )
            self._begun.update((index, held) for index in range(chunk.index, end))

    def _take_bounds(self, chunk: Any, topology: Topology) -> bytes:
        end = chunk.first_edge + len(chunk.data)
        if end > 3 * topology.patches:
            raise LatticedError.data_loss(
                f"chunk {chunk.index} has bounds of edges up to {end}, {topology.patches} patches have fewer"
            )
        self._begun_bounds.append((chunk.first_edge, chunk.data))
        return b""

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
            self._chunks, self._bounds = [None] * self._topology.chunks, bytearray()
        self._chunks = [self._begun.get(i, chunk) for i, chunk in enumerate(self._chunks)]
        whole = [chunk for chunk in self._chunks if chunk is not None]
        if self._topology is None or len(whole) != self._topology.chunks:
            raise LatticedError.data_loss("an update ended before every chunk had come")
        for first, bounds in self._begun_bounds:
            self._bounds.extend(bytes(max(0, first - len(self._bounds))))
            self._bounds[first : first + len(bounds)] = bounds
        # Always asked for, so that it forgets those of earlier revisions.
        lattice = self._lattices.at(end.revision)
        if self._begun_sum:
            lattice = self._sums.at(end.revision)
        self.drop_partial_update()
        view = View.from_proto(begin.view)
        bounds = bytes(self._bounds) if view.encoding == "patches" else b""
        return Update(end, view, self._topology, whole, lattice, bounds)
