// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/device/device_stage.h"

#include <utility>
#include <vector>

#include "core/base/status_macros.h"
#include "core/ffd/box/bernstein.h"
#include "core/ffd/tessellation_pattern.h"
#include "cuda/device/table_upload.h"

namespace latticed {
namespace {

template <typename Triple>
std::vector<uchar4> Pack(const std::vector<Triple>& triples) {
  std::vector<uchar4> packed;
  packed.reserve(triples.size());
  for (const auto& t : triples) {
    packed.push_back({static_cast<unsigned char>(t[0]), static_cast<unsigned char>(t[1]),
                      static_cast<unsigned char>(t[2]), 0});
  }
  return packed;
}

}  // namespace

absl::StatusOr<std::shared_ptr<const DeviceStage>> DeviceStage::Create(int degree, int segments,
                                                                       DeviceReservation& from,
                                                                       const CudaStream& stream) {
  LATTICED_ASSIGN_OR_RETURN(const auto host, StageMatrices::Get(degree, segments));
  std::shared_ptr<DeviceStage> stage(new DeviceStage(host));
  TableUpload upload;
  upload.Add(Pack(host->samples), stage->samples_);
  upload.Add(Pack(TessellationPattern::Get(segments).points), stage->pattern_);
  upload.Add(host->stack, stage->stack_);
  upload.Add(host->bernstein_f, stage->bernstein_f_);
  upload.Add(host->bernstein, stage->bernstein_);
  upload.Add(host->inverse, stage->inverse_);
  LATTICED_ASSIGN_OR_RETURN(stage->block_, upload.Send(from, "stage_matrices", stream.get()));
  LATTICED_RETURN_IF_ERROR(stream.Synchronize("the stage matrices"));
  return stage;
}

uint64_t DeviceStage::DeviceBytesFor(int degree, int segments) {
  const auto m = static_cast<size_t>(BernsteinCount(degree)),
             q = static_cast<size_t>(PointsPerPatch(segments));
  // In the order in which Create adds the tables.
  return TableUpload::BlockBytes({m * sizeof(uchar4), q * sizeof(uchar4), 3 * q * m * sizeof(float),
                                  3 * q * m * sizeof(float), 3 * q * m * sizeof(double),
                                  m * m * sizeof(double)});
}

}  // namespace latticed
