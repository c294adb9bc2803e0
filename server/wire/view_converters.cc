// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/wire/view_converters.h"

#include <array>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/wire/enum_table.h"

namespace latticed {
namespace {

constexpr auto kNormals = std::to_array<std::pair<v1::NormalMode, NormalMode>>(
    {{v1::NORMAL_MODE_NONE, NormalMode::kNone},
     {v1::NORMAL_MODE_FACET, NormalMode::kFacet},
     {v1::NORMAL_MODE_SMOOTH, NormalMode::kSmooth}});

// Without ENCODING_CONTROL_NETS, which is reserved.
constexpr auto kEncodings = std::to_array<std::pair<v1::Encoding, Encoding>>(
    {{v1::ENCODING_DRACO_POINTS, Encoding::kDracoPoints},
     {v1::ENCODING_DRACO_MESH, Encoding::kDracoMesh},
     {v1::ENCODING_RAW, Encoding::kRaw},
     {v1::ENCODING_QUANTISED, Encoding::kQuantised},
     {v1::ENCODING_PATCHES, Encoding::kPatches},
     {v1::ENCODING_MESHOPT, Encoding::kMeshopt}});

// Takes the numbers of `options` that are not 0.
absl::Status TakeNumbers(const v1::ViewOptions& options, std::string_view field, WatchView& view) {
  struct Number {
    int32_t given;
    int lowest, highest;
    std::string_view name;
    int& target;
  };
  ViewSpec& spec = view.key.spec;
  const Number numbers[] = {
      {options.segments(), limits::kMinSegments, limits::kMaxSegments, "segments", spec.segments},
      {options.position_bits(), limits::kMinPositionBits, limits::kMaxPositionBits, "position_bits",
       spec.position_bits},
      {options.normal_bits(), limits::kMinNormalBits, limits::kMaxNormalBits, "normal_bits",
       spec.normal_bits},
      {options.drag_position_bits(), limits::kMinPositionBits, limits::kMaxPositionBits,
       "drag_position_bits", view.drag_position_bits},
      {options.drag_normal_bits(), limits::kMinNormalBits, limits::kMaxNormalBits,
       "drag_normal_bits", view.drag_normal_bits}};
  for (const auto& [given, lowest, highest, name, target] : numbers) {
    if (given == 0) continue;
    if (given < lowest || given > highest) {
      return error::OutOfRange(fmt::format("{}.{}", field, name), given, lowest, highest);
    }
    target = given;
  }
  return absl::OkStatus();
}

// A tolerance chooses the bits that come without a number of their own. Segments alone ask for a view without one.
absl::Status TakeTolerance(const v1::ViewOptions& options, std::string_view field, ViewSpec& spec) {
  const double tolerance = options.tolerance();
  if (!std::isfinite(tolerance)) return error::NotFinite(fmt::format("{}.tolerance", field));
  if (tolerance < 0) {
    return error::InvalidField(fmt::format("{}.tolerance", field),
                               fmt::format("got {}, allowed is 0 or more", tolerance),
                               "OUT_OF_RANGE");
  }
  if (tolerance > 0) {
    spec.tolerance = tolerance;
    if (options.position_bits() == 0) spec.position_bits = 0;
  } else if (options.segments() != 0) {
    spec.tolerance = 0;
    if (spec.position_bits == 0) spec.position_bits = ViewSpec{}.position_bits;
  }
  return absl::OkStatus();
}

}  // namespace

WatchView DefaultView(bool smooth) {
  WatchView view;
  view.key.spec.normals = smooth ? NormalMode::kSmooth : NormalMode::kFacet;
  return view;
}

absl::StatusOr<WatchView> DefaultViewFromProto(const v1::ViewOptions& options,
                                               const WatchView& defaults, std::string_view field) {
  WatchView view = defaults;
  LATTICED_ASSIGN_OR_RETURN(view.key.spec.normals,
                            NormalModeFromProto(options.normals(), view.key.spec.normals,
                                                fmt::format("{}.normals", field)));
  if (options.encoding() != v1::ENCODING_UNSPECIFIED) {
    LATTICED_ASSIGN_OR_RETURN(view.key.encoding, ReadEnum(kEncodings, options.encoding(),
                                                          fmt::format("{}.encoding", field)));
  }
  LATTICED_RETURN_IF_ERROR(TakeNumbers(options, field, view));
  LATTICED_RETURN_IF_ERROR(TakeTolerance(options, field, view.key.spec));
  view.key.spec.format = FormatOf(view.key.encoding);
  if (options.max_points() != 0) view.max_points = options.max_points();
  if (options.max_bytes_per_second() != 0) {
    view.max_bytes_per_second = options.max_bytes_per_second();
  }
  return view;
}

absl::StatusOr<WatchView> WatchViewFromProto(const v1::ViewOptions& options,
                                             const WatchView& defaults, std::string_view field) {
  auto view = DefaultViewFromProto(options, defaults, field);
  if (!view.ok()) return view;
  ViewSpec& spec = view->key.spec;
  if (!HasPositions(spec)) {
    return WatchView{
        .key = {{.normals = NormalMode::kNone, .format = spec.format}, view->key.encoding},
        .client_normals = spec.normals};
  }
  const bool raw = spec.format == VertexFormat::kFloat32;
  if (raw) {
    const int bits = defaults.key.spec.position_bits;
    spec.position_bits = bits != 0 ? bits : ViewSpec{}.position_bits;
    view->drag_position_bits = 0;
  }
  if (raw || spec.normals == NormalMode::kNone) {
    spec.normal_bits = defaults.key.spec.normal_bits;
    view->drag_normal_bits = 0;
  }
  return view;
}

absl::StatusOr<NormalMode> NormalModeFromProto(v1::NormalMode mode, NormalMode unspecified,
                                               std::string_view field) {
  if (mode == v1::NORMAL_MODE_UNSPECIFIED) return unspecified;
  return ReadEnum(kNormals, mode, field);
}

v1::NormalMode ToProto(NormalMode mode) { return WriteEnum(kNormals, mode); }

v1::ViewOptions ToProto(const WatchView& view) {
  v1::ViewOptions result;
  result.set_segments(view.key.spec.segments);
  result.set_normals(ToProto(view.client_normals.value_or(view.key.spec.normals)));
  result.set_encoding(WriteEnum(kEncodings, view.key.encoding));
  result.set_position_bits(view.key.spec.position_bits);
  result.set_normal_bits(view.key.spec.normal_bits);
  result.set_max_points(view.max_points);
  result.set_max_bytes_per_second(view.max_bytes_per_second);
  result.set_drag_position_bits(view.drag_position_bits);
  result.set_drag_normal_bits(view.drag_normal_bits);
  result.set_tolerance(view.key.spec.tolerance);
  return result;
}

}  // namespace latticed
