// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/device/device_stage.h"

#include <vector>

#include "core/ffd/tessellation_pattern.h"

namespace latticed {
namespace {

constexpr char kMatricesPurpose[] = "stage_matrices";

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

absl::StatusOr<std::shared_ptr<const DeviceStage>> DeviceStage::Create(
    int degree, int segments, std::shared_ptr<DeviceMemory> memory, const CudaStream& stream) {
  const auto host = StageMatrices::Get(degree, segments);
  if (!host.ok()) return host.status();
  std::shared_ptr<DeviceStage> stage(new DeviceStage(*host));
  if (auto s = stage->Upload(memory, stream); !s.ok()) return s;
  return stage;
}

absl::Status DeviceStage::Upload(const std::shared_ptr<DeviceMemory>& memory,
                                 const CudaStream& stream) {
  absl::Status status;
  const auto upload = [&]<typename T>(const std::vector<T>& from, DeviceBuffer<T>& to) {
    if (!status.ok()) return;
    auto buffer = DeviceBuffer<T>::Upload(memory, kMatricesPurpose, from, stream.get());
    status = buffer.status();
    if (buffer.ok()) to = *std::move(buffer);
  };
  upload(Pack(host_->samples), samples_);
  upload(Pack(TessellationPattern::Get(segments()).points), pattern_);
  upload(host_->stack, stack_);
  upload(host_->bernstein_f, bernstein_f_);
  upload(host_->bernstein, bernstein_);
  upload(host_->inverse, inverse_);
  status.Update(stream.Synchronize("the stage matrices"));
  return status;
}

size_t DeviceStage::MemoryBytes() const {
  return samples_.size_bytes() + pattern_.size_bytes() + stack_.size_bytes() +
         bernstein_f_.size_bytes() + bernstein_.size_bytes() + inverse_.size_bytes();
}

}  // namespace latticed
