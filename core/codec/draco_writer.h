// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Our writer of Draco streams. Stock decoders read them to exactly the integers that went in. The bytes depend on those
// integers alone, not on the instructions that the machine has.
#ifndef LATTICED_CORE_CODEC_DRACO_WRITER_H_
#define LATTICED_CORE_CODEC_DRACO_WRITER_H_

#include <memory>
#include <vector>

#include "core/base/mutex.h"
#include "core/codec/chunk_encoder.h"

namespace latticed {

// A backend with vertices on a device may write the same bytes there (cuda/draco/draco_kernels.h).
inline constexpr std::string_view kDracoWriterName = "latticed";

class DracoWriter final : public ChunkEncoder {
 public:
  DracoWriter();
  ~DracoWriter() override;
  std::string_view name() const override { return kDracoWriterName; }
  size_t batch() const override;
  uint64_t WorkingBytes(size_t points, int position_bits, int normal_bits) const override;
  absl::Status Encode(std::span<const QuantisedVertices> chunks, double range,
                      const ChunkConnectivity* connectivity,
                      std::span<std::vector<uint8_t>> streams) const override;

  // The memory kept between calls, without that of calls that run now.
  uint64_t MemoryBytes() const;

 private:
  class Group;

  std::unique_ptr<Group> TakeGroup() const;

  mutable Mutex mutex_;
  // Groups that are free for the next call. The one used last is at the end: its memory may still be cached.
  mutable std::vector<std::unique_ptr<Group>> idle_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed

#endif  // LATTICED_CORE_CODEC_DRACO_WRITER_H_
