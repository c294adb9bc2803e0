// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/wire/scene_converters.h"

#include <algorithm>
#include <memory>
#include <string_view>
#include <utility>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "google/protobuf/io/coded_stream.h"
#include "google/protobuf/io/zero_copy_stream_impl_lite.h"
#include "server/base/auth/tenant.h"
#include "server/base/labels.h"
#include "server/wire/constraint_converters.h"
#include "server/wire/converters.h"
#include "server/wire/enum_table.h"
#include "server/wire/mesh_units.h"
#include "server/wire/time_converters.h"
#include "server/wire/view_converters.h"

namespace latticed {
namespace {

constexpr auto kPipelines = std::to_array<std::pair<v1::Pipeline, Pipeline>>(
    {{v1::PIPELINE_FUSED, Pipeline::kFused},
     {v1::PIPELINE_GEMM, Pipeline::kGemm},
     {v1::PIPELINE_GEMM12, Pipeline::kGemm12},
     {v1::PIPELINE_CONTROL_NET, Pipeline::kControlNet},
     {v1::PIPELINE_UNSPECIFIED, Pipeline::kFused}});

// nullopt stands for the Bézier control nets.
constexpr auto kExportFormats =
    std::to_array<std::pair<v1::ExportFormat, std::optional<MeshFormat>>>(
        {{v1::EXPORT_FORMAT_PLY, MeshFormat::kPly},
         {v1::EXPORT_FORMAT_OBJ, MeshFormat::kObj},
         {v1::EXPORT_FORMAT_STL, MeshFormat::kStl},
         {v1::EXPORT_FORMAT_GLB, MeshFormat::kGlb},
         {v1::EXPORT_FORMAT_DRC, MeshFormat::kDraco},
         {v1::EXPORT_FORMAT_CONTROL_NETS, std::nullopt},
         {v1::EXPORT_FORMAT_USD, MeshFormat::kUsd},
         {v1::EXPORT_FORMAT_UNSPECIFIED, MeshFormat::kPly}});

constexpr auto kExportGeometries = std::to_array<std::pair<v1::ExportGeometry, ExportGeometry>>(
    {{v1::EXPORT_GEOMETRY_EXACT, ExportGeometry::kExact},
     {v1::EXPORT_GEOMETRY_ORIGINAL, ExportGeometry::kOriginal},
     {v1::EXPORT_GEOMETRY_PATCHES, ExportGeometry::kPatches},
     {v1::EXPORT_GEOMETRY_UNSPECIFIED, ExportGeometry::kExact}});

Labels LabelsOf(const v1::CreateSceneRequest& request) {
  return {request.labels().begin(), request.labels().end()};
}

absl::Status CheckSceneId(const std::string& id) {
  const bool known = std::ranges::all_of(
      id, [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-'; });
  if (known && id.size() >= limits::kMinSceneIdBytes && id.size() <= limits::kMaxSceneIdBytes) {
    return absl::OkStatus();
  }
  return error::InvalidField(
      "scene_id", fmt::format("must be {} to {} of a-z 0-9 -, such as 128 random bits in hex",
                              limits::kMinSceneIdBytes, limits::kMaxSceneIdBytes));
}

absl::StatusOr<absl::Duration> IdleTtl(const v1::CreateSceneRequest& request,
                                       absl::Duration unset) {
  if (!request.has_idle_ttl()) return unset;
  // The range of google.protobuf.Duration, about 10,000 years.
  constexpr int64_t kMostSeconds = 315'576'000'000;
  constexpr int32_t kMostNanos = 999'999'999;
  const auto& ttl = request.idle_ttl();
  const bool positive =
      (ttl.seconds() > 0 && ttl.nanos() >= 0) || (ttl.seconds() == 0 && ttl.nanos() > 0);
  if (!positive || ttl.seconds() > kMostSeconds || ttl.nanos() > kMostNanos) {
    return error::InvalidField(
        "idle_ttl",
        fmt::format("got {} s and {} ns, allowed is 0 to {} s with 0 to {} ns, not both 0",
                    ttl.seconds(), ttl.nanos(), kMostSeconds, kMostNanos),
        "OUT_OF_RANGE");
  }
  return absl::Seconds(ttl.seconds()) + absl::Nanoseconds(ttl.nanos());
}

// A digest, because the request may hold a large lattice. Maps are written in a fixed order, so that equal
// requests have equal bytes.
std::string Fingerprint(const v1::CreateSceneRequest& request, const std::string& owner) {
  std::string bytes;
  {
    google::protobuf::io::StringOutputStream stream(&bytes);
    google::protobuf::io::CodedOutputStream coded(&stream);
    coded.SetSerializationDeterministic(true);
    request.SerializeToCodedStream(&coded);
  }
  return Sha256Hex(owner + '\0' + bytes);
}

std::string WithoutEnding(const std::string& name) {
  const size_t dot = name.rfind('.');
  return dot == 0 ? name : name.substr(0, dot);
}

VertexWeights FloatsOf(std::string_view bytes) {
  std::vector<float> floats(bytes.size() / sizeof(float));
  std::ranges::copy(bytes, reinterpret_cast<char*>(floats.data()));
  return std::make_shared<const std::vector<float>>(std::move(floats));
}

// The weights that a request names, checked.
absl::StatusOr<VertexWeights> WeightsFromProto(const v1::VertexWeights& message,
                                               const std::shared_ptr<const PolygonMesh>& mesh) {
  VertexWeights weights;
  switch (message.source_case()) {
    case v1::VertexWeights::kValues:
      if (message.values().size() % sizeof(float) != 0) {
        return error::InvalidField(
            "weights.values",
            fmt::format("{} bytes are no whole number of float32", message.values().size()));
      }
      weights = FloatsOf(message.values());
      break;
    case v1::VertexWeights::kFromMesh:
      if (!message.from_mesh()) {
        return error::InvalidField("weights.from_mesh", "must be true where it is set");
      }
      if (mesh->weights.empty()) {
        return error::InvalidField(
            "weights.from_mesh",
            "the mesh's file has none: no property weight (PLY), no weights (RAW), and no "
            "attribute _WEIGHT (GLB)");
      }
      weights = VertexWeights(mesh, &mesh->weights);  // keeps the mesh, and copies nothing
      break;
    case v1::VertexWeights::SOURCE_NOT_SET:
      if (HoldsUnknown(message)) return error::Unsupported("weights", "this kind of weights");
      return error::InvalidField("weights", "values or from_mesh must be set");
  }
  LATTICED_RETURN_IF_ERROR(CheckVertexWeights(*mesh, *weights));
  return weights;
}

absl::StatusOr<std::vector<Lattice>> LatticesFromProto(const v1::CreateSceneRequest& request,
                                                       const StoredMesh& mesh) {
  const v1::LatticeSource fit_with_defaults;
  std::vector<Lattice> lattices;
  for (int k = 0; k < std::max(request.lattices_size(), 1); ++k) {
    LATTICED_ASSIGN_OR_RETURN(
        auto lattice,
        FromProto(request.lattices_size() > 0 ? request.lattices(k) : fit_with_defaults,
                  mesh.bounds, fmt::format("lattices[{}]", k), mesh.mesh->positions));
    lattices.push_back(std::move(lattice));
  }
  return lattices;
}

}  // namespace

absl::Status CheckCreateScene(const v1::CreateSceneRequest& request) {
  LATTICED_RETURN_IF_ERROR(CheckSceneId(request.scene_id()));
  if (request.mesh().empty()) return error::InvalidField("mesh", "is required");
  LATTICED_RETURN_IF_ERROR(
      error::CheckRange("lattices", request.lattices_size(), 0, limits::kMaxLattices));
  if (auto ttl = IdleTtl(request, absl::ZeroDuration()); !ttl.ok()) return ttl.status();
  LATTICED_RETURN_IF_ERROR(error::CheckRange("name", static_cast<double>(request.name().size()), 0,
                                             static_cast<double>(limits::kMaxNameBytes)));
  return CheckLabels(LabelsOf(request), "labels");
}

absl::StatusOr<SceneConfig> SceneConfigFromProto(const v1::CreateSceneRequest& request,
                                                 const StoredMesh& mesh, const std::string& owner,
                                                 absl::Duration default_idle_ttl) {
  LATTICED_ASSIGN_OR_RETURN(auto lattices, LatticesFromProto(request, mesh));
  const bool smooth = mesh.mesh->has_normals() || request.has_crease_angle();
  LATTICED_ASSIGN_OR_RETURN(
      auto view, DefaultViewFromProto(request.default_view(), DefaultView(smooth), "default_view"));
  LATTICED_ASSIGN_OR_RETURN(
      const auto pipeline,
      ReadEnum(kPipelines, request.diagnostics().pipeline(), "diagnostics.pipeline"));
  const double strength = request.has_strength() ? request.strength() : 1;
  LATTICED_RETURN_IF_ERROR(CheckStrength(strength, "strength"));
  VertexWeights weights;
  if (request.has_weights()) {
    LATTICED_ASSIGN_OR_RETURN(weights, WeightsFromProto(request.weights(), mesh.mesh));
  }
  LATTICED_ASSIGN_OR_RETURN(const auto idle_ttl, IdleTtl(request, default_idle_ttl));
  LATTICED_RETURN_IF_ERROR(error::CheckRange("crease_angle", request.crease_angle(), 0, 180));
  LATTICED_ASSIGN_OR_RETURN(auto units, MeshUnitsFromProto(request.units(), "units"));
  if (units.up_axis.empty()) units.up_axis = mesh.units.up_axis;
  if (units.meters_per_unit == 0) units.meters_per_unit = mesh.units.meters_per_unit;

  SceneConfig config;
  config.id = TenantKey(TenantOf(mesh.id), request.scene_id());
  config.mesh_id = mesh.id;
  config.name = request.name().empty() ? WithoutEnding(mesh.name) : request.name();
  config.mesh = mesh.mesh;
  config.lattices = std::move(lattices);
  if (request.has_crease_angle()) config.crease_angle = request.crease_angle();
  config.strength = strength;
  config.weights = std::move(weights);
  config.units = std::move(units);
  config.default_view = view;
  config.pipeline = pipeline;
  config.idle_ttl = idle_ttl;
  config.fold_watch = request.fold_watch();
  config.labels = LabelsOf(request);
  config.owner = owner;
  config.fingerprint = Fingerprint(request, owner);
  return config;
}

v1::Scene ToProto(const SceneConfig& config) {
  v1::Scene result;
  result.set_id(std::string(IdOf(config.id)));
  result.set_mesh(std::string(IdOf(config.mesh_id)));
  result.set_name(config.name);
  *result.mutable_default_view() = ToProto(config.default_view);
  SetDuration(config.idle_ttl, *result.mutable_idle_ttl());
  result.mutable_labels()->insert(config.labels.begin(), config.labels.end());
  result.set_pipeline(WriteEnum(kPipelines, config.pipeline));
  SetTime(config.create_time, *result.mutable_create_time());
  result.set_owner(config.owner);
  result.set_fold_watch(config.fold_watch);
  result.set_weighted(config.weights != nullptr);
  *result.mutable_units() = ToProto(config.units);
  if (config.crease_angle.has_value()) result.set_crease_angle(*config.crease_angle);
  return result;
}

v1::Scene ToProto(const Scene& scene) {
  const auto state = scene.State();
  v1::Scene result = ToProto(scene.config());
  for (const SceneLattice& lattice : state->lattices) {
    *result.add_lattices() = SummaryToProto(lattice.structure());
    result.mutable_lattices()->rbegin()->set_index(lattice.number);
  }
  result.set_pipeline(WriteEnum(kPipelines, scene.pipeline()));
  result.set_weighted(state->plan->is_weighted());
  result.set_strength(state->lattices[0].map->strength());
  result.set_revision(state->revision);
  result.set_structure_id(state->structure_id);
  result.set_patches(state->plan->patches.size());
  result.set_patches_outside(state->plan->outside_patches);
  result.set_patches_on_faces(state->patches_on_faces);
  result.set_chunks(state->plan->chunk_count());
  for (const auto& [purpose, bytes] : scene.memory()) (*result.mutable_bytes())[purpose] = bytes;
  if (const absl::Time expires = scene.expire_time(); expires != absl::InfiniteFuture()) {
    SetTime(expires, *result.mutable_expire_time());
  }
  return result;
}

v1::LatticeState LatticeStateToProto(const SceneState& state, size_t place) {
  const SceneLattice& lattice = state.lattices[place];
  v1::LatticeState result;
  result.set_index(lattice.number);
  for (const SceneLattice& one : state.lattices) result.add_indexes(one.number);
  *result.mutable_lattice() = ToProto(lattice.structure(), *lattice.points);
  result.set_structure_id(state.structure_id);
  result.set_revision(state.revision);
  if (lattice.map->strength() != 1) result.set_strength(lattice.map->strength());
  if (*lattice.constraints != Constraints{}) {
    *result.mutable_constraints() = ToProto(*lattice.constraints);
  }
  return result;
}

absl::StatusOr<ExportSpec> ExportSpecFromProto(const v1::ExportRequest& request,
                                               const WatchView& defaults) {
  LATTICED_ASSIGN_OR_RETURN(const auto format,
                            ReadEnum(kExportFormats, request.format(), "format"));
  // Segments and tolerance count, whatever the encoding of the default view.
  LATTICED_ASSIGN_OR_RETURN(const auto view,
                            DefaultViewFromProto(request.view(), defaults, "view"));
  LATTICED_ASSIGN_OR_RETURN(const auto geometry,
                            ReadEnum(kExportGeometries, request.geometry(), "geometry"));
  if (geometry != ExportGeometry::kExact && !format.has_value()) {
    return error::InvalidField("geometry", "control nets are of the exact surface only");
  }
  ExportSpec spec;
  spec.format = format;
  spec.geometry = geometry;
  spec.segments = view.key.spec.segments;
  spec.normals = view.key.spec.normals;
  // Control nets and the uploaded mesh are not tessellated.
  const bool tessellated = format.has_value() && geometry != ExportGeometry::kOriginal;
  if (tessellated) spec.tolerance = view.key.spec.tolerance;
  if (request.view().position_bits() != 0) {
    spec.position_bits = request.view().position_bits();
  } else if (spec.tolerance > 0) {
    spec.position_bits = 0;
  }
  if (request.view().normal_bits() != 0) spec.normal_bits = request.view().normal_bits();
  return spec;
}

}  // namespace latticed
