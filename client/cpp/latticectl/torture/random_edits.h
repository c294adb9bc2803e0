// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The edits of one editor of a scene: most set or move some control points; some undo or redo, and a few insert a knot.
// Each editor has control points of his own, so that he can undo what he did.
//
// All of them give the same bits on every machine: positions are set, an offset is one addition, and a knot goes to the
// middle of a span of degree 1, where both weights are 1/2.
//
// Threads  one at a time
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_TORTURE_RANDOM_EDITS_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_TORTURE_RANDOM_EDITS_H_

#include <cstdint>
#include <random>

#include "core/ffd/edit/lattice_edit.h"
#include "latticed/v1/edit.pb.h"
#include "latticed/v1/lattice.pb.h"

namespace latticed::client {

// The lattice of the scenes: its last axis has degree 1.
[[nodiscard]] v1::LatticeFit TorturedLattice();

class RandomEdits {
 public:
  // Editor `editor` of `editors`, counted from 0.
  RandomEdits(uint32_t seed, uint32_t editor, uint32_t editors)
      : random_(seed), editor_(editor), editors_(editors) {}

  // An edit of this lattice, with its structure. Editor and sequence are not set.
  [[nodiscard]] EditBatch Next(const v1::LatticeState& state);

 private:
  Edit NextEdit(const v1::Lattice& lattice);
  Edit NewKnot(const v1::Lattice& lattice);
  Edit NewPositions(const v1::Lattice& lattice);
  Edit NewOffset(const v1::Lattice& lattice);
  std::vector<uint32_t> SomePoints(const v1::Lattice& lattice);
  // 0 … below - 1.
  uint32_t Below(uint32_t below) { return static_cast<uint32_t>(random_()) % below; }
  // A little of the size of the lattice, either way.
  double Little(const v1::Lattice& lattice);

  std::mt19937 random_;
  const uint32_t editor_, editors_;
};

// Of the edits that RandomEdits makes.
[[nodiscard]] v1::EditBatch ToProto(const EditBatch& batch);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_TORTURE_RANDOM_EDITS_H_
