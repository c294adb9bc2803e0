// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <ostream>

#include "client/cpp/latticectl/command_line/failure.h"
#include "client/cpp/latticectl/command_line/message_flags.h"
#include "client/cpp/latticectl/commands/commands.h"
#include "client/cpp/latticectl/output/output.h"
#include "client/cpp/latticectl/session/scene_patches.h"
#include "client/cpp/latticectl/session/scene_tolerance.h"
#include "client/cpp/latticectl/session/session.h"
#include "client/cpp/library/encodings/encoding_choice.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

struct WatchFlags : ServerFlags {
  std::string scene;
  v1::ViewOptions view;
  Tolerance tolerance;
  uint64_t updates = std::numeric_limits<uint64_t>::max();
};

// The points of an update: those that were sent, or those that this program has made.
struct UpdatePoints {
  uint64_t count = 0;
  double tolerance = 0, certified_error = 0;
  bool own = false;
};

absl::StatusOr<UpdatePoints> PointsOf(const Surface& surface, double tolerance,
                                      ScenePatches& patches) {
  if (surface.view().encoding() != v1::ENCODING_PATCHES) {
    return UpdatePoints{surface.PointCount(), surface.view().tolerance(),
                        surface.certified_error()};
  }
  if (tolerance == 0) return UpdatePoints();
  LATTICED_RETURN_IF_ERROR(patches.Evaluate(surface));
  return UpdatePoints{patches.points().positions.size(), tolerance, patches.certified_error(),
                      /*own=*/true};
}

// Prints one line per update, also in JSON, and flushes it at once, because a watch has no end.
void PrintUpdate(const CompleteUpdate& update, const UpdatePoints& points, bool json,
                 std::ostream& out) {
  const v1::UpdateTimings& timings = update.end.timings();
  if (json) {
    out << nlohmann::json{{"revision", update.end.revision()},
                          {"headRevision", update.end.head_revision()},
                          {"chunks", update.chunk_count},
                          {"bytes", update.bytes},
                          {"certifiedError", points.certified_error},
                          {"points", points.count},
                          {"evaluateUs", timings.evaluate_us()},
                          {"encodeUs", timings.encode_us()},
                          {"sendUs", timings.send_us()}}
               .dump();
  } else {
    out << fmt::format("revision {}: {} chunks, {}; evaluated in {}, encoded in {}{}",
                       update.end.revision(), FormatCount(update.chunk_count),
                       FormatBytes(update.bytes), FormatMilliseconds(timings.evaluate_us() / 1e3),
                       FormatMilliseconds(timings.encode_us() / 1e3),
                       DescribeCertificate(points.tolerance, points.certified_error, points.own));
  }
  out << std::endl;
}

absl::Status RunWatch(const WatchFlags& flags, Client& client, Console console) {
  v1::WatchRequest request;
  request.set_scene(flags.scene);
  *request.mutable_view() = flags.view;
  LATTICED_RETURN_IF_ERROR(
      SetTolerance(client, flags.scene, flags.tolerance, request.mutable_view()));
  LATTICED_ASSIGN_OR_RETURN(const std::string reason,
                            ChooseOpenEncoding(client, flags.scene, *request.mutable_view()));
  const double tolerance = request.view().tolerance();
  ScenePatches patches(client, flags.scene, tolerance);
  LATTICED_ASSIGN_OR_RETURN(const auto watch, client.Watch(std::move(request)));
  if (!reason.empty()) {
    const v1::Encoding chosen = watch->surface().view().encoding();
    PrintNotice(fmt::format("by {}: {}", EncodingName(chosen), reason), flags.json, console.err);
  }
  std::optional<CompleteUpdate> update = watch->first_update();
  for (uint64_t count = 0; update.has_value();) {
    LATTICED_ASSIGN_OR_RETURN(const auto points, PointsOf(watch->surface(), tolerance, patches));
    PrintUpdate(*update, points, flags.json, console.out);
    if (++count >= flags.updates) return absl::OkStatus();
    LATTICED_ASSIGN_OR_RETURN(update, watch->Next());
  }
  return absl::OkStatus();
}

}  // namespace

void AddWatchCommand(CLI::App& app, CommandLine& line) {
  auto flags = std::make_shared<WatchFlags>();
  CLI::App* command = app.add_subcommand("watch", "Prints a line for every update of a scene");
  command->add_option("scene", flags->scene, "Id of the scene")->required();
  command->add_option("--updates", flags->updates, "Ends after this many updates; by default never")
      ->check(CLI::PositiveNumber);
  AddViewFlags(*command, flags->view, ViewDefaults::kOfScene);
  command->get_option("--encoding")->default_str("the faster one");
  AddToleranceFlag(*command, flags->tolerance);
  AddDragFlags(*command, flags->view);
  SetExample(*command, "watch my-scene --updates 10");
  SetServerAction(*command, flags, line, RunWatch);
}

}  // namespace latticed::client
