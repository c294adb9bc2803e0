// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/wire/view_converters.h"

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed {
namespace {

// Takes `value` into `target` where it is not 0.
absl::Status TakeInRange(int32_t value, int lowest, int highest, std::string_view field,
                         std::string_view name, int& target) {
  if (value == 0) return absl::OkStatus();
  if (value < lowest || value > highest) {
    return error::OutOfRange(fmt::format("{}.{}", field, name), value, lowest, highest);
  }
  target = value;
  return absl::OkStatus();
}

absl::Status TakeDragBits(const v1::ViewOptions& options, std::string_view field, WatchView& view) {
  LATTICED_RETURN_IF_ERROR(TakeInRange(options.drag_position_bits(), limits::kMinPositionBits,
                                       limits::kMaxPositionBits, field, "drag_position_bits",
                                       view.drag_position_bits));
  return TakeInRange(options.drag_normal_bits(), limits::kMinNormalBits, limits::kMaxNormalBits,
                     field, "drag_normal_bits", view.drag_normal_bits);
}

absl::Status TakeBits(const v1::ViewOptions& options, std::string_view field, ViewSpec& spec) {
  LATTICED_RETURN_IF_ERROR(TakeInRange(options.segments(), limits::kMinSegments,
                                       limits::kMaxSegments, field, "segments", spec.segments));
  LATTICED_RETURN_IF_ERROR(TakeInRange(options.position_bits(), limits::kMinPositionBits,
                                       limits::kMaxPositionBits, field, "position_bits",
                                       spec.position_bits));
  return TakeInRange(options.normal_bits(), limits::kMinNormalBits, limits::kMaxNormalBits, field,
                     "normal_bits", spec.normal_bits);
}

template <typename Enum>
absl::Status UnknownValue(std::string_view field, Enum value) {
  return error::Unsupported(field, fmt::format("value {}", static_cast<int>(value)));
}

}  // namespace

WatchView DefaultView(bool mesh_has_normals) {
  WatchView view;
  view.key.spec.normals = mesh_has_normals ? NormalMode::kSmooth : NormalMode::kFacet;
  return view;
}

absl::StatusOr<WatchView> DefaultViewFromProto(const v1::ViewOptions& options,
                                               const WatchView& defaults, std::string_view field) {
  WatchView view = defaults;
  LATTICED_ASSIGN_OR_RETURN(
      const auto normals,
      FromProto(options.normals(), defaults.key.spec.normals, fmt::format("{}.normals", field)));
  LATTICED_ASSIGN_OR_RETURN(
      const auto encoding,
      FromProto(options.encoding(), defaults.key.encoding, fmt::format("{}.encoding", field)));
  LATTICED_RETURN_IF_ERROR(TakeBits(options, field, view.key.spec));
  LATTICED_RETURN_IF_ERROR(TakeDragBits(options, field, view));
  view.key.spec.normals = normals;
  view.key.encoding = encoding;
  view.key.spec.format = FormatOf(encoding);
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
  const bool raw = spec.format == VertexFormat::kFloat32;
  if (raw) {
    spec.position_bits = defaults.key.spec.position_bits;
    view->drag_position_bits = 0;
  }
  if (raw || spec.normals == NormalMode::kNone) {
    spec.normal_bits = defaults.key.spec.normal_bits;
    view->drag_normal_bits = 0;
  }
  return view;
}

v1::ViewOptions ToProto(const WatchView& view) {
  v1::ViewOptions result;
  result.set_segments(view.key.spec.segments);
  result.set_normals(ToProto(view.key.spec.normals));
  result.set_encoding(ToProto(view.key.encoding));
  result.set_position_bits(view.key.spec.position_bits);
  result.set_normal_bits(view.key.spec.normal_bits);
  result.set_max_points(view.max_points);
  result.set_max_bytes_per_second(view.max_bytes_per_second);
  result.set_drag_position_bits(view.drag_position_bits);
  result.set_drag_normal_bits(view.drag_normal_bits);
  return result;
}

absl::StatusOr<NormalMode> FromProto(v1::NormalMode mode, NormalMode unspecified,
                                     std::string_view field) {
  switch (mode) {
    case v1::NORMAL_MODE_UNSPECIFIED:
      return unspecified;
    case v1::NORMAL_MODE_NONE:
      return NormalMode::kNone;
    case v1::NORMAL_MODE_FACET:
      return NormalMode::kFacet;
    case v1::NORMAL_MODE_SMOOTH:
      return NormalMode::kSmooth;
    default:
      return UnknownValue(field, mode);
  }
}

v1::NormalMode ToProto(NormalMode mode) {
  switch (mode) {
    case NormalMode::kNone:
      return v1::NORMAL_MODE_NONE;
    case NormalMode::kFacet:
      return v1::NORMAL_MODE_FACET;
    case NormalMode::kSmooth:
      return v1::NORMAL_MODE_SMOOTH;
  }
  return v1::NORMAL_MODE_UNSPECIFIED;
}

absl::StatusOr<Encoding> FromProto(v1::Encoding encoding, Encoding unspecified,
                                   std::string_view field) {
  switch (encoding) {
    case v1::ENCODING_UNSPECIFIED:
      return unspecified;
    case v1::ENCODING_DRACO_POINTS:
      return Encoding::kDracoPoints;
    case v1::ENCODING_DRACO_MESH:
      return Encoding::kDracoMesh;
    case v1::ENCODING_RAW:
      return Encoding::kRaw;
    case v1::ENCODING_QUANTISED:
      return Encoding::kQuantised;
    default:
      return UnknownValue(field, encoding);  // CONTROL_NETS is reserved
  }
}

v1::Encoding ToProto(Encoding encoding) {
  switch (encoding) {
    case Encoding::kRaw:
      return v1::ENCODING_RAW;
    case Encoding::kQuantised:
      return v1::ENCODING_QUANTISED;
    case Encoding::kDracoPoints:
      return v1::ENCODING_DRACO_POINTS;
    case Encoding::kDracoMesh:
      return v1::ENCODING_DRACO_MESH;
  }
  return v1::ENCODING_UNSPECIFIED;
}

absl::StatusOr<Pipeline> FromProto(v1::Pipeline pipeline, std::string_view field) {
  switch (pipeline) {
    case v1::PIPELINE_UNSPECIFIED:
    case v1::PIPELINE_FUSED:
      return Pipeline::kFused;
    case v1::PIPELINE_GEMM:
      return Pipeline::kGemm;
    case v1::PIPELINE_GEMM12:
      return Pipeline::kGemm12;
    case v1::PIPELINE_CONTROL_NET:
      return Pipeline::kControlNet;
    default:
      return UnknownValue(field, pipeline);
  }
}

v1::Pipeline ToProto(Pipeline pipeline) {
  switch (pipeline) {
    case Pipeline::kFused:
      return v1::PIPELINE_FUSED;
    case Pipeline::kGemm:
      return v1::PIPELINE_GEMM;
    case Pipeline::kGemm12:
      return v1::PIPELINE_GEMM12;
    case Pipeline::kControlNet:
      return v1::PIPELINE_CONTROL_NET;
  }
  return v1::PIPELINE_UNSPECIFIED;
}

absl::StatusOr<UploadFormat> FromProto(v1::MeshFormat format, std::string_view field) {
  switch (format) {
    case v1::MESH_FORMAT_UNSPECIFIED:
      return error::InvalidField(field, "is required");
    case v1::MESH_FORMAT_OBJ:
      return UploadFormat::kObj;
    case v1::MESH_FORMAT_PLY:
      return UploadFormat::kPly;
    case v1::MESH_FORMAT_STL:
      return UploadFormat::kStl;
    case v1::MESH_FORMAT_GLB:
      return UploadFormat::kGlb;
    case v1::MESH_FORMAT_DRACO:
      return UploadFormat::kDraco;
    case v1::MESH_FORMAT_RAW:
      return UploadFormat::kRaw;
    default:
      return UnknownValue(field, format);
  }
}

v1::MeshFormat ToProto(UploadFormat format) {
  switch (format) {
    case UploadFormat::kObj:
      return v1::MESH_FORMAT_OBJ;
    case UploadFormat::kPly:
      return v1::MESH_FORMAT_PLY;
    case UploadFormat::kStl:
      return v1::MESH_FORMAT_STL;
    case UploadFormat::kGlb:
      return v1::MESH_FORMAT_GLB;
    case UploadFormat::kDraco:
      return v1::MESH_FORMAT_DRACO;
    case UploadFormat::kRaw:
      return v1::MESH_FORMAT_RAW;
  }
  return v1::MESH_FORMAT_UNSPECIFIED;
}

v1::MeshFormat ToProto(MeshFormat format) {
  switch (format) {
    case MeshFormat::kObj:
      return v1::MESH_FORMAT_OBJ;
    case MeshFormat::kPly:
      return v1::MESH_FORMAT_PLY;
    case MeshFormat::kStl:
      return v1::MESH_FORMAT_STL;
    case MeshFormat::kGlb:
      return v1::MESH_FORMAT_GLB;
    case MeshFormat::kDraco:
      return v1::MESH_FORMAT_DRACO;
  }
  return v1::MESH_FORMAT_UNSPECIFIED;
}

absl::StatusOr<std::optional<MeshFormat>> FromProto(v1::ExportFormat format,
                                                    std::string_view field) {
  switch (format) {
    case v1::EXPORT_FORMAT_UNSPECIFIED:
    case v1::EXPORT_FORMAT_PLY:
      return MeshFormat::kPly;
    case v1::EXPORT_FORMAT_OBJ:
      return MeshFormat::kObj;
    case v1::EXPORT_FORMAT_STL:
      return MeshFormat::kStl;
    case v1::EXPORT_FORMAT_GLB:
      return MeshFormat::kGlb;
    case v1::EXPORT_FORMAT_DRC:
      return MeshFormat::kDraco;
    case v1::EXPORT_FORMAT_CONTROL_NETS:
      return std::optional<MeshFormat>();
    default:
      return UnknownValue(field, format);
  }
}

v1::ExportFormat ExportFormatToProto(std::optional<MeshFormat> format) {
  if (!format.has_value()) return v1::EXPORT_FORMAT_CONTROL_NETS;
  switch (*format) {
    case MeshFormat::kObj:
      return v1::EXPORT_FORMAT_OBJ;
    case MeshFormat::kPly:
      return v1::EXPORT_FORMAT_PLY;
    case MeshFormat::kStl:
      return v1::EXPORT_FORMAT_STL;
    case MeshFormat::kGlb:
      return v1::EXPORT_FORMAT_GLB;
    case MeshFormat::kDraco:
      return v1::EXPORT_FORMAT_DRC;
  }
  return v1::EXPORT_FORMAT_UNSPECIFIED;
}

}  // namespace latticed
