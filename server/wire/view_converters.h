// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Views and enums of latticed.v1 <-> types of core.
//
// Errors   kInvalidArgument with the path of the field, which begins with the argument `field`;
//          reason UNSUPPORTED for an enum value that this server does not know
// Threads  pure functions
#ifndef LATTICED_SERVER_WIRE_VIEW_CONVERTERS_H_
#define LATTICED_SERVER_WIRE_VIEW_CONVERTERS_H_

#include <optional>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/backend.h"
#include "core/mesh/mesh_io.h"
#include "latticed/v1/mesh.pb.h"
#include "latticed/v1/scene.pb.h"
#include "latticed/v1/surface.pb.h"
#include "latticed/v1/view.pb.h"
#include "server/engine/render/snapshot.h"
#include "server/engine/watch/watch_view.h"
#include "server/stores/mesh_store.h"

namespace latticed {

// Views. DefaultView is what ViewOptions documents, smooth where the mesh has normals.
[[nodiscard]] WatchView DefaultView(bool mesh_has_normals);
// What is 0 or UNSPECIFIED comes from `defaults`. For a scene's default view.
[[nodiscard]] absl::StatusOr<WatchView> DefaultViewFromProto(const v1::ViewOptions& options,
                                                             const WatchView& defaults,
                                                             std::string_view field);
// The same for a watcher: bits that have no effect are those of the defaults, so that views that
// cannot be told apart are one.
[[nodiscard]] absl::StatusOr<WatchView> WatchViewFromProto(const v1::ViewOptions& options,
                                                           const WatchView& defaults,
                                                           std::string_view field);
[[nodiscard]] v1::ViewOptions ToProto(const WatchView& view);

// Enums.
[[nodiscard]] absl::StatusOr<NormalMode> FromProto(v1::NormalMode mode, NormalMode unspecified,
                                                   std::string_view field);
[[nodiscard]] v1::NormalMode ToProto(NormalMode mode);
[[nodiscard]] absl::StatusOr<Encoding> FromProto(v1::Encoding encoding, Encoding unspecified,
                                                 std::string_view field);
[[nodiscard]] v1::Encoding ToProto(Encoding encoding);
[[nodiscard]] absl::StatusOr<Pipeline> FromProto(v1::Pipeline pipeline, std::string_view field);
[[nodiscard]] v1::Pipeline ToProto(Pipeline pipeline);
// INVALID_FIELD where unspecified.
[[nodiscard]] absl::StatusOr<UploadFormat> FromProto(v1::MeshFormat format, std::string_view field);
[[nodiscard]] v1::MeshFormat ToProto(UploadFormat format);
// nullopt is the Bézier control nets; PLY where unspecified.
[[nodiscard]] absl::StatusOr<std::optional<MeshFormat>> FromProto(v1::ExportFormat format,
                                                                  std::string_view field);
[[nodiscard]] v1::ExportFormat ExportFormatToProto(std::optional<MeshFormat> format);

}  // namespace latticed

#endif  // LATTICED_SERVER_WIRE_VIEW_CONVERTERS_H_
