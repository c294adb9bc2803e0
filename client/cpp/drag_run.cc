// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/drag_run.h"

#include <algorithm>
#include <cmath>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "core/mesh/obj_io.h"
#include "core/mesh/sample_meshes.h"

namespace latticed::client {

double DragResult::bytes_per_update() const {
  return latencies_ms.empty()
             ? 0.0
             : static_cast<double>(bytes) / static_cast<double>(latencies_ms.size());
}

double DragResult::LatencyAt(double p) const {
  if (latencies_ms.empty()) return 0;
  std::vector<double> sorted = latencies_ms;
  std::sort(sorted.begin(), sorted.end());
  const double rank = std::ceil(p * static_cast<double>(sorted.size()));
  return sorted[static_cast<size_t>(std::max(rank, 1.0)) - 1];
}

absl::StatusOr<DragResult> RunDrag(DeformStream& stream, int steps,
                                   const std::function<v1::EditBatch(int)>& make_edit,
                                   const Progress& progress) {
  DragResult result;
  for (int step = 0; step < steps; ++step) {
    const absl::Time begin = absl::Now();
    const auto sequence = stream.Send(make_edit(step));
    if (!sequence.ok()) return sequence.status();
    const auto update = stream.WaitFor(*sequence);
    if (!update.ok()) return update.status();
    result.latencies_ms.push_back(absl::ToDoubleMilliseconds(absl::Now() - begin));
    result.bytes += update->bytes;
    result.chunks += update->chunk_count;
    progress(static_cast<uint64_t>(step) + 1, static_cast<uint64_t>(steps));
  }
  return result;
}

absl::StatusOr<MeshFile> SampleOrFile(const std::string& name) {
  const auto names = SampleMeshNames();
  if (std::find(names.begin(), names.end(), name) == names.end()) return ReadMeshFile(name);
  const auto mesh = MakeSampleMesh(name);
  if (!mesh.ok()) return mesh.status();
  return MeshFile{name + ".obj", MeshFormat::kObj, WriteObj(*mesh)};
}

}  // namespace latticed::client
