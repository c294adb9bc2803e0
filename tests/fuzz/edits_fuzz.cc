// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Applies a sequence of EditBatch messages in text form, separated by lines of "--", to one lattice. The
// lattice must be valid after each, and a refused batch must not change it.
#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "core/ffd/history/edit_history.h"
#include "server/wire/edit_converters.h"

namespace {

// Unknown fields and broken text are expected. The parser must not write errors to stderr.
class Silence : public google::protobuf::io::ErrorCollector {
  void AddError(int, google::protobuf::io::ColumnNumber, const std::string&) override {}
};

const latticed::PolygonMesh& Triangle() {
  static const auto* const kMesh =
      new latticed::PolygonMesh{.positions = {{0, 0, 0}, {1, 2, 0}, {0, 1, 3}},
                                .face_offsets = {0, 3},
                                .corner_vertices = {0, 1, 2}};
  return *kMesh;
}

latticed::Lattice StartLattice() {
  latticed::Bounds bounds;
  bounds.Extend(latticed::Vec3d{0, 0, 0});
  bounds.Extend(latticed::Vec3d{1, 2, 3});
  return *latticed::FitLattice(bounds, {4, 3, 3}, {2, 1, 2}, 0.05);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  constexpr size_t kMostBatches = 64;  // keeps the time of an input near a millisecond or below
  std::string_view rest(reinterpret_cast<const char*>(data), size);
  latticed::EditHistory history(StartLattice());
  const auto now = std::chrono::steady_clock::time_point{};
  for (size_t i = 0; i < kMostBatches && !rest.empty(); ++i) {
    const size_t end = std::min(rest.find("--\n"), rest.size());
    latticed::v1::EditBatch message;
    Silence silence;
    google::protobuf::TextFormat::Parser parser;
    parser.RecordErrorsTo(&silence);
    parser.SetRecursionLimit(16);
    const bool parsed = parser.ParseFromString(std::string(rest.substr(0, end)), &message);
    rest.remove_prefix(std::min(rest.size(), end + 3));
    if (!parsed) continue;
    const auto batch = latticed::FromProto(message, Triangle());
    if (!batch.ok()) continue;
    const uint64_t revision = history.revision();
    const latticed::Lattice before = history.lattice();
    const auto outcome = history.Apply(
        *batch, now, [](const latticed::LatticeStructure&) { return absl::OkStatus(); });
    if (!latticed::Validate(history.lattice()).ok()) std::abort();
    if (outcome.ok()) continue;
    if (history.revision() != revision || !(history.lattice().structure == before.structure)) {
      std::abort();
    }
    if (history.lattice().control_points != before.control_points) std::abort();
  }
  return 0;
}
