// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/cpu_view.h"

#include <algorithm>
#include <functional>
#include <mutex>
#include <new>
#include <utility>

#include "core/base/error.h"
#include "fmt/format.h"

namespace latticed {
namespace {

std::vector<std::array<uint32_t, 3>> ChunkTriangles(int segments) {
  const TessellationPattern& pattern = TessellationPattern::Get(segments);
  std::vector<std::array<uint32_t, 3>> triangles;
  triangles.reserve(pattern.triangles.size() * limits::kPatchesPerChunk);
  for (uint32_t p = 0; p < static_cast<uint32_t>(limits::kPatchesPerChunk); ++p) {
    const uint32_t base = p * static_cast<uint32_t>(pattern.points.size());
    for (const auto& t : pattern.triangles) {
      triangles.push_back({base + t[0], base + t[1], base + t[2]});
    }
  }
  return triangles;
}

}  // namespace

absl::StatusOr<std::unique_ptr<CpuView>> CpuView::Create(std::shared_ptr<const DeformPlan> plan,
                                                         const ViewSpec& spec,
                                                         std::unique_ptr<VertexKernel> kernel,
                                                         std::shared_ptr<CpuContext> context) {
  const size_t own_bytes = kernel->OwnOrderBytes();
  auto vertices = HostBuffer::Create(
      "vertices", own_bytes > 0 ? own_bytes : VertexLayout(*plan, spec).total_bytes());
  if (!vertices.ok()) return vertices.status();
  return std::unique_ptr<CpuView>(new CpuView(std::move(plan), spec, std::move(kernel),
                                              std::move(context), *std::move(vertices)));
}

CpuView::CpuView(std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
                 std::unique_ptr<VertexKernel> kernel, std::shared_ptr<CpuContext> context,
                 HostBuffer vertices)
    : plan_(std::move(plan)),
      spec_(spec),
      layout_(*plan_, spec_),
      context_(std::move(context)),
      kernel_(std::move(kernel)),
      vertices_(std::move(vertices)) {}

absl::Status CpuView::CheckChunk(uint32_t chunk) const {
  if (chunk < plan_->chunk_count()) return absl::OkStatus();
  return error::OutOfRange("chunks", chunk, 0, static_cast<double>(plan_->chunk_count()) - 1);
}

absl::Status CpuView::CheckEvaluate(std::span<const Vec3d> control_points,
                                    const QuantisationBox& box,
                                    std::span<const uint32_t> chunks) const {
  const auto expected = static_cast<size_t>(plan_->structure.control_point_count());
  if (control_points.size() != expected) {
    return error::InvalidField(
        "lattice.control_points",
        fmt::format("got {} points, {} are needed", control_points.size(), expected));
  }
  if (!chunks.empty()) {
    if (auto status = CheckChunk(chunks.back()); !status.ok()) return status;
  }
  if (!std::is_sorted(chunks.begin(), chunks.end(), std::less_equal<>())) {
    return error::InvalidField("chunks", "must rise, each chunk once");
  }
  const bool same_box = box_ && box_->origin == box.origin && box_->range == box.range;
  const bool boxed = spec_.format == VertexFormat::kQuantised;
  if ((!box_ || (boxed && !same_box)) && chunks.size() != plan_->chunk_count()) {
    return error::InvalidField("chunks",
                               "the first evaluation, and one under another box, needs all");
  }
  return absl::OkStatus();
}

absl::Status CpuView::Evaluate(std::span<const Vec3d> control_points, const QuantisationBox& box,
                               std::span<const uint32_t> chunks) {
  if (auto status = CheckEvaluate(control_points, box, chunks); !status.ok()) return status;
  try {
    if (auto status = kernel_->Evaluate(control_points, box, chunks, vertices_.span());
        !status.ok()) {
      box_.reset();
      return status;
    }
  } catch (const std::bad_alloc&) {
    box_.reset();
    return error::AllocationFailed("the evaluation");
  }
  box_ = box;
  return absl::OkStatus();
}

std::span<const uint8_t> CpuView::ChunkBytes(uint32_t chunk) const {
  return vertices_.span().subspan(layout_.ChunkOffset(chunk), layout_.ChunkBytes(chunk));
}

absl::Status CpuView::Read(uint32_t chunk, std::span<uint8_t> out) {
  if (auto status = CheckChunk(chunk); !status.ok()) return status;
  if (!box_) return error::FailedPrecondition("NOT_EVALUATED", "evaluate the view first");
  if (out.size() != layout_.ChunkBytes(chunk)) {
    return error::InvalidField("out", fmt::format("got room for {} bytes, chunk {} has {}",
                                                  out.size(), chunk, layout_.ChunkBytes(chunk)));
  }
  CopyChunk(chunk, out);
  return absl::OkStatus();
}

void CpuView::CopyChunk(uint32_t chunk, std::span<uint8_t> out) const {
  if (kernel_->OwnOrderBytes() > 0) return kernel_->ReadChunk(vertices_.span(), chunk, out);
  const std::span<const uint8_t> bytes = ChunkBytes(chunk);
  std::copy(bytes.begin(), bytes.end(), out.begin());
}

absl::StatusOr<std::vector<uint8_t>> CpuView::EncodeChunk(uint32_t chunk, Encoding encoding) const {
  if (encoding == Encoding::kRaw || encoding == Encoding::kQuantised) {
    std::vector<uint8_t> bytes(layout_.ChunkBytes(chunk));
    CopyChunk(chunk, bytes);
    return bytes;
  }
  const std::span<const uint8_t> bytes = ChunkBytes(chunk);
  const size_t points = ChunkPoints(*plan_, chunk, spec_.segments);
  const int normal_bits = spec_.normals == NormalMode::kNone ? 0 : spec_.normal_bits;
  const QuantisedVertices vertices =
      QuantisedVertices::FromBytes(bytes, points, spec_.position_bits, normal_bits);
  if (encoding == Encoding::kDracoPoints) {
    return context_->encoder->EncodePoints(vertices, box_->range);
  }
  const auto [first, last] = plan_->ChunkPatches(chunk);
  const size_t triangles = (last - first) * static_cast<size_t>(TrianglesPerPatch(spec_.segments));
  return context_->encoder->EncodeMesh(vertices, box_->range,
                                       std::span(triangles_).first(triangles));
}

absl::StatusOr<std::vector<SharedBytes>> CpuView::Encode(std::span<const uint32_t> chunks,
                                                         Encoding encoding) {
  if (!box_) return error::FailedPrecondition("NOT_EVALUATED", "evaluate the view first");
  if (FormatOf(encoding) != spec_.format) {
    return error::InvalidField("encoding", "its vertex format must be the view's");
  }
  for (uint32_t chunk : chunks) {
    if (auto status = CheckChunk(chunk); !status.ok()) return status;
  }
  std::vector<SharedBytes> results;
  std::mutex mutex;
  absl::Status first_error;
  try {
    if (encoding == Encoding::kDracoMesh && triangles_.empty()) {
      triangles_ = ChunkTriangles(spec_.segments);
    }
    results.resize(chunks.size());
    context_->arena.ForEach(chunks.size(), [&](size_t i) {
      auto bytes = EncodeChunk(chunks[i], encoding);
      if (bytes.ok()) {
        results[i] = MakeSharedBytes(*std::move(bytes));
        return;
      }
      const std::scoped_lock lock(mutex);
      first_error.Update(bytes.status());
    });
  } catch (const std::bad_alloc&) {
    return error::AllocationFailed("the encoding");
  }
  if (!first_error.ok()) return first_error;
  return results;
}

MemoryUse CpuView::memory() const {
  MemoryUse use = kernel_->memory();
  use["vertices"] += vertices_.size();
  use["staging"] += triangles_.capacity() * sizeof(triangles_[0]);
  return use;
}

}  // namespace latticed
