// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The one interface of evaluation. A backend is an object that is chosen at run time by name. One call handles a whole
// frame, so virtual dispatch costs nothing. Everything that does not depend on control points is in the plan. The plan
// is made on the host and shared, so that backends agree.
//
//   Backend --Prepare(plan, pipeline)--> DeformTarget --CreateView(spec)--> DeformView
//
//   DeformTarget::Traits  properties of a view, before it is made
//   DeformView::Evaluate  control points -> vertices of the named chunks, kept by the backend
//   DeformView::Read      vertices of one chunk -> host memory, in wire layout
//   DeformView::Encode    vertices of chunks that changed -> encoded bytes in host memory
//
//   Backend --PreparePoints(points)--> PointEvaluator: points of the world and their derivatives, by the million
//
// Positions are relative to plan->local_origin (float32) or to the quantisation box (integers).
// Threads  a DeformTarget is immutable and may be shared; a DeformView is used by one thread at a
// time.
#ifndef LATTICED_CORE_BACKEND_H_
#define LATTICED_CORE_BACKEND_H_

#include <algorithm>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/limits.h"
#include "core/ffd/plan/deform_plan.h"
#include "core/ffd/plan/quantisation_box.h"

namespace latticed {

// How vertices are computed; all give the same answer within the precision of core/README.md.
enum class Pipeline {
  kFused,       // lattice to vertices in one pass
  kGemm,        // formulas (24), (25): one product each; the reference
  kGemm12,      // formulas (18), (21)-(23): three small products, then nine
  kControlNet,  // formulas (6), (17): Bézier control points first
};

enum class NormalMode { kNone, kFacet, kSmooth };

// The format of a view's vertices: chunk by chunk, in a chunk patch by patch, in a patch in pattern
// order.
enum class VertexFormat {
  kFloat32,    // interleaved x y z [nx ny nz]: the RAW encoding
  kQuantised,  // planar uint16 x[] y[] z[], then [uint8 (normal_bits <= 8) or uint16 s[] t[]]
  // No vertices: EdgeBoundByte of each edge of the chunk (core/patches/edge_order.h). Of the spec, nothing else has an
  // effect.
  kEdgeBounds,
};

enum class Encoding { kRaw, kQuantised, kDracoPoints, kDracoMesh, kPatches, kMeshopt };
[[nodiscard]] VertexFormat FormatOf(Encoding encoding);
[[nodiscard]] bool IsDraco(Encoding encoding);  // points or mesh
// Whether the bytes of a chunk depend on its vertices, and not only on their number.
[[nodiscard]] bool IsCompressed(Encoding encoding);

struct ViewSpec {
  // Subdivisions per patch edge. With a tolerance: the view has at most as many points as these would give.
  int segments = 10;
  // The largest distance, both ways, between the exact surface and the triangles of the vertices, in world units. 0: all
  // patches have `segments`. Above 0, each patch has a pattern of its own (core/adaptive/adaptive_pattern.h).
  double tolerance = 0;
  NormalMode normals = NormalMode::kFacet;
  VertexFormat format = VertexFormat::kQuantised;
  int position_bits = 12;  // ignored for kFloat32
  int normal_bits = 8;     // ignored for kFloat32

  friend auto operator<=>(const ViewSpec&, const ViewSpec&) = default;
};

// Whether views have positions. Only these depend on the quantisation box.
[[nodiscard]] inline bool HasPositions(const ViewSpec& spec) {
  return spec.format != VertexFormat::kEdgeBounds;
}

// Bytes of one point in wire layout. 0 for kEdgeBounds.
[[nodiscard]] size_t BytesPerPoint(const ViewSpec& spec);

// Reference-counted immutable bytes: a slice of a buffer that `owner` keeps alive.
struct SharedBytes {
  std::shared_ptr<const void> owner;
  const uint8_t* data = nullptr;
  size_t size = 0;
  size_t block_bytes = 0;  // all that `owner` keeps, if these are only a part; else 0
  std::span<const uint8_t> span() const { return {data, size}; }
};
[[nodiscard]] SharedBytes MakeSharedBytes(std::vector<uint8_t> bytes);

// A digest of a chunk's vertices. Within the views of one target and spec, equal digests mean equal vertices. Zeros: no
// vertices. Host and devices have different ones for the same vertices: of 127 bits, and the lowest is 1 on a device.
struct VertexDigest {
  uint64_t low = 0, high = 0;

  // Whether the vertices differ for sure. False: they may be equal.
  bool DiffersForSure(const VertexDigest& other) const {
    const bool both = *this != VertexDigest() && other != VertexDigest();
    return both && low % 2 == other.low % 2 && *this != other;
  }
  friend bool operator==(const VertexDigest&, const VertexDigest&) = default;
};

// Bytes by purpose: "plan", "stage_matrices", "samples", "vertices", "staging", "chunks". A purpose that begins with
// "device_", such as "device_vertices", is in a device's memory; all others are in the host's.
using MemoryUse = std::map<std::string, uint64_t>;
inline constexpr std::string_view kDevicePurpose = "device_";
[[nodiscard]] uint64_t HostBytes(const MemoryUse& use);
[[nodiscard]] uint64_t DeviceBytes(const MemoryUse& use);

// Bytes by device, as DeviceState::number names it.
using DeviceUse = std::map<int, uint64_t>;

// The present state of a device. 0: unknown.
struct DeviceState {
  int number = 0;    // what the command line calls it
  std::string name;  // for people
  uint64_t memory_bytes = 0;
  uint64_t budget_bytes = 0;  // what all plans and views may take together; 0: no budget of its own
  uint64_t free_bytes = 0;    // of the budget where there is one, else of the memory
  MemoryUse use;              // of the budget; all on the device, so without a prefix
};

// Properties of the views of one spec.
struct ViewTraits {
  // Vertices are in a device's memory, and an evaluation uses no core of the host.
  bool on_device = false;
  // The most host memory that a view takes: vertices where no device keeps them, staging, scratch.
  uint64_t host_bytes = 0;
  // Host memory that all threads together take to encode Draco streams. The backend keeps it for
  // the next encoding, so all views of all specs together take the largest of these.
  uint64_t encoder_bytes = 0;
  // The best number of chunks for one call of Encode. More only delay the caller.
  size_t encode_batch = 256;
  // The first chunk of each device, ascending from 0, where several share a plan. Each takes its
  // part of encode_batch.
  std::vector<uint32_t> device_chunks = {0};
};

// Returns `chunks`, which ascend, in the order in which to encode them, traits.encode_batch per call. In this order
// each call has work for every device.
[[nodiscard]] std::vector<uint32_t> EncodeOrder(const ViewTraits& traits,
                                                std::span<const uint32_t> chunks);

class PointEvaluator;  // core/points/point_evaluator.h
class ReachSlice;      // core/view/spanned/reach_slice.h
class SortedPoints;    // core/points/sorted_points.h
class ToleranceSlice;  // core/view/spanned/tolerance_slice.h

// The patterns of a view with a tolerance. They stay as they are while `owner` is kept; else until the view evaluates again.
struct PatternCodes {
  std::shared_ptr<const void> owner;
  std::span<const uint16_t> codes;  // PatternKey::Code by patch; none without a tolerance

  std::span<const uint16_t> OfChunk(size_t chunk) const {
    constexpr size_t kPatches = limits::kPatchesPerChunk;
    const size_t first = std::min(chunk * kPatches, codes.size());
    return codes.subspan(first, std::min(kPatches, codes.size() - first));
  }
};

// Takes the results of some chunks of an encoding before it has ended: of chunks[first], of the next one, and so on.
using TakeEarly = absl::FunctionRef<void(size_t first, std::span<SharedBytes> results,
                                         std::span<const VertexDigest> digests)>;
inline void TakeNothing(size_t, std::span<SharedBytes>, std::span<const VertexDigest>) {}

class DeformView {
 public:
  virtual ~DeformView() = default;

  virtual const ViewSpec& spec() const = 0;

  // Evaluates the vertices of `chunks` (sorted, distinct) for `control_points` and `box`. The first
  // call, and each call with another box, must name all chunks. Others may be evaluated
  // too: on CUDA, GEMM pipelines evaluate all patches of uniform views. kUnavailable when the device is lost.
  [[nodiscard]] virtual absl::Status Evaluate(std::span<const Vec3d> control_points,
                                              const QuantisationBox& box,
                                              std::span<const uint32_t> chunks) = 0;

  // With a tolerance or of bounds, after Evaluate: the chunks beyond those named that changed, ascending. The level or the
  // bound of an edge changed there, which a named patch shares.
  [[nodiscard]] virtual std::span<const uint32_t> also_changed() const { return {}; }
  // With a tolerance, after Evaluate: those of all patches.
  [[nodiscard]] virtual PatternCodes Patterns() const { return {}; }
  // With a tolerance, after Evaluate: the bound that the vertices keep. It exceeds the tolerance where the bits, the levels
  // or the number of points do not suffice.
  [[nodiscard]] virtual double certified_error() const { return 0; }
  // With a tolerance, after Evaluate: the part of it, or of its double, that levels and patterns were chosen with. They and
  // the vertices of a patch follow from this number, the box, and the bounds of the patch and its neighbours.
  [[nodiscard]] virtual double curvature_tolerance() const { return 0; }

  // With a tolerance: how it is evaluated where its plan is a slice and devices must agree on levels. Null: not at all.
  [[nodiscard]] virtual ToleranceSlice* tolerance_slice() { return nullptr; }
  // Of bounds: what slices must share so that their bounds are those of the whole plan. Null: devices cannot share them.
  [[nodiscard]] virtual ReachSlice* reach_slice() { return nullptr; }

  // Copies the vertices of one chunk in wire layout: ChunkPoints * BytesPerPoint bytes, or its bounds, one byte each.
  [[nodiscard]] virtual absl::Status Read(uint32_t chunk, std::span<uint8_t> out) = 0;

  // Encodes the vertices of `chunks`; the results are in the same order. Chunks of one device must ascend, as
  // EncodeOrder puts them. The encoding's format must be the view's. `digests` is empty or has one entry per chunk: the
  // digest of the vertices whose bytes the caller already has, under this encoding and box. Encode replaces it by the
  // present digest. If the two are equal, nothing is encoded and the result has no data. A view without digests
  // encodes all and sets zeros.
  //
  // A device still encodes or copies when it knows some results, with their digests. Encode may call `early` with these, on the
  // caller's thread; it tells a chunk again if it encodes it again. Their bytes must not be read before Encode returns.
  // `early` may move results out, which then come without data. After an error results and digests are void.
  [[nodiscard]] virtual absl::StatusOr<std::vector<SharedBytes>> Encode(
      std::span<const uint32_t> chunks, Encoding encoding, std::span<VertexDigest> digests,
      TakeEarly early) = 0;
  [[nodiscard]] absl::StatusOr<std::vector<SharedBytes>> Encode(
      std::span<const uint32_t> chunks, Encoding encoding, std::span<VertexDigest> digests = {}) {
    return Encode(chunks, encoding, digests, TakeNothing);
  }

  [[nodiscard]] virtual MemoryUse memory() const = 0;
};

class DeformTarget {
 public:
  virtual ~DeformTarget() = default;
  virtual const DeformPlan& plan() const = 0;
  virtual Pipeline pipeline() const = 0;
  // Whether it has views of kEdgeBounds.
  [[nodiscard]] virtual bool has_edge_bounds() const { return false; }
  // The traits of the views that CreateView makes for `spec`, which must be valid.
  [[nodiscard]] virtual ViewTraits Traits(const ViewSpec& spec) const = 0;
  // kInvalidArgument for a spec out of limits; kResourceExhausted with asked and free bytes.
  [[nodiscard]] virtual absl::StatusOr<std::unique_ptr<DeformView>> CreateView(
      const ViewSpec& spec) = 0;
  // Bézier control nets of patches [first, last): m x 3 doubles per patch, world coordinates, in the
  // order T_{n,0,0}, T_{n-1,1,0}, …, T_{0,0,n} of formula (3). With vertex weights n is one more.
  [[nodiscard]] virtual absl::StatusOr<std::vector<double>> ControlNets(
      std::span<const Vec3d> control_points, size_t first, size_t last) = 0;
  [[nodiscard]] virtual MemoryUse memory() const = 0;
  // The bytes of memory() that are on each device. The bytes of its views have the same
  // proportions.
  [[nodiscard]] virtual DeviceUse device_use() const { return {}; }
};

class Backend {
 public:
  virtual ~Backend() = default;
  virtual std::string_view name() const = 0;  // "cpu", "cuda"
  // A description for people: "AVX-512, 2 threads, OpenBLAS SkylakeX".
  virtual std::string description() const = 0;
  // The devices that evaluate; the host itself for the CPU backend. Empty where nothing is known.
  [[nodiscard]] virtual std::vector<DeviceState> devices() const { return {}; }
  // What else the bytes of a pipeline depend on, beside the build and the names of the devices: versions of libraries, and
  // sizes of products, for which these may choose other kernels.
  [[nodiscard]] virtual std::string Arithmetic(Pipeline /*pipeline*/) const { return ""; }
  [[nodiscard]] virtual absl::StatusOr<std::shared_ptr<DeformTarget>> Prepare(
      std::shared_ptr<const DeformPlan> plan, Pipeline pipeline) = 0;
  // Brings points to a device. Null for a backend without one: core/points/host_points.h evaluates them there.
  [[nodiscard]] virtual absl::StatusOr<std::shared_ptr<PointEvaluator>> PreparePoints(
      std::shared_ptr<const SortedPoints> /*points*/) {
    return nullptr;
  }
};

[[nodiscard]] absl::Status Validate(const ViewSpec& spec);
// kFailedPrecondition, reason TURNED_LATTICES, for a plan with turned lattices and kFused.
[[nodiscard]] absl::Status CheckSupported(const DeformPlan& plan, Pipeline pipeline);
[[nodiscard]] size_t ChunkPoints(const DeformPlan& plan, size_t chunk, int segments);
// The points of patches with these patterns, PatternKey::Code of each.
[[nodiscard]] size_t PatternPoints(std::span<const uint16_t> patterns);
// kInvalidArgument, reason UNSUPPORTED, for bounds that the target's views cannot have.
[[nodiscard]] absl::Status CheckSupported(const DeformTarget& target, const ViewSpec& spec);
// The points of a chunk of a view of `plan`, with a tolerance after Evaluate.
[[nodiscard]] size_t ChunkPoints(const DeformView& view, const DeformPlan& plan, uint32_t chunk);

}  // namespace latticed

#endif  // LATTICED_CORE_BACKEND_H_
