// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Edits that remove lattices from a scene of several, and put others there.
#ifndef LATTICED_TESTS_SERVER_LATTICES_REMOVED_FIXTURE_H_
#define LATTICED_TESTS_SERVER_LATTICES_REMOVED_FIXTURE_H_

#include <string>
#include <vector>

#include "tests/server/lattices/several_fixture.h"

namespace latticed::testing {

using Numbered = std::vector<uint32_t>;

class RemovedLatticesTest : public SeveralLatticesTest {
 protected:
  // An edit of a lattice at the scene's structure, by an editor of one sequence.
  v1::EditBatch Batch(uint32_t number, const std::string& editor = "ann") {
    v1::EditBatch batch = MoveIn(number, ++sequence_, 0, {});
    batch.set_editor_id(editor);
    batch.set_structure_id(Get().structure_id());
    batch.clear_edits();
    return batch;
  }
  v1::EditBatch Remove(uint32_t number, const std::string& editor = "ann") {
    v1::EditBatch batch = Batch(number, editor);
    batch.add_edits()->mutable_remove_lattice();
    return batch;
  }
  v1::EditBatch Undo(uint32_t number, const std::string& editor = "ann") {
    v1::EditBatch batch = Batch(number, editor);
    batch.add_edits()->mutable_undo();
    return batch;
  }
  v1::EditBatch Redo(uint32_t number, const std::string& editor = "ann") {
    v1::EditBatch batch = Batch(number, editor);
    batch.add_edits()->mutable_redo();
    return batch;
  }
  v1::EditBatch Push(uint32_t number, uint32_t index, Vec3d offset,
                     const std::string& editor = "ann") {
    v1::EditBatch batch = Batch(number, editor);
    auto& move = *batch.add_edits()->mutable_move_control_points();
    move.add_indices(index);
    *move.mutable_offset() = ToVec3(offset);
    return batch;
  }
  v1::EditBatch Put(uint32_t number, const v1::Lattice& lattice) {
    v1::EditBatch batch = Batch(number);
    *batch.add_edits()->mutable_replace_lattice()->mutable_lattice() = lattice;
    return batch;
  }
  std::vector<uint32_t> Numbers() {
    std::vector<uint32_t> numbers;
    const v1::Scene scene = Get();
    for (const auto& lattice : scene.lattices()) numbers.push_back(lattice.index());
    return numbers;
  }
  absl::Status GetLattice(uint32_t number) {
    auto request = For<v1::GetLatticeRequest>();
    request.set_lattice(number);
    v1::LatticeState state;
    return Call(&Scenes::GetLattice, request, &state);
  }
  uint64_t sequence_ = 0;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_LATTICES_REMOVED_FIXTURE_H_
