// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/scene/copied_history.h"

#include <cmath>
#include <cstdint>
#include <string_view>
#include <utility>

#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/engine/lattices/scene_history.h"
#include "server/store/records/header_codec.h"
#include "server/store/records/scene_codec.h"

namespace latticed {
namespace {

// More than any scene can reach, and databases count to 2^63.
constexpr uint64_t kMostCount = uint64_t{1} << 62;

absl::Status CannotBe(std::string_view what) {
  return absl::DataLossError(fmt::format("the history of a scene: {}", what));
}

bool IsOf(const EditStep& step, uint64_t clock) {
  return step.id <= clock && step.structure_step <= clock && step.written_at <= clock;
}

absl::Status CheckCounts(const EditHistoryImage& history) {
  for (const uint64_t count : {history.revision, history.structure_id, history.records,
                               history.clock, history.base.structure_step}) {
    if (count > kMostCount) return CannotBe("a number is out of range");
  }
  if (history.structure_id == 0) return CannotBe("a number is out of range");
  // A later step must get an id that no step has.
  if (history.base.structure_step > history.clock) return CannotBe("a step is of the future");
  for (const EditStep& step : history.steps) {
    if (!IsOf(step, history.clock)) return CannotBe("a step is of the future");
  }
  for (const UndoneStep& undone : history.undone) {
    if (!IsOf(undone.step, history.clock) || undone.undone_at > history.clock) {
      return CannotBe("a step is of the future");
    }
  }
  return absl::OkStatus();
}

absl::Status CheckBox(const QuantisationBox& box) {
  const Vec3d& origin = box.origin;
  const bool finite = std::isfinite(origin.x) && std::isfinite(origin.y) &&
                      std::isfinite(origin.z) && std::isfinite(box.range);
  if (!finite || box.range <= 0 || box.id > kMostCount) return CannotBe("its quantisation box");
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckCopied(const SceneLog& log) {
  if (log.snapshot_lsn == 0) {
    return log.snapshot.empty() ? absl::OkStatus() : CannotBe("it has no edits, and is not empty");
  }
  LATTICED_ASSIGN_OR_RETURN(SceneImage image, DecodeImage(log.snapshot));
  uint64_t records = 0;
  for (const EditHistoryImage& history : image.histories) {
    LATTICED_RETURN_IF_ERROR(CheckCounts(history));
    records += history.records;
  }
  if (records != log.snapshot_lsn) return CannotBe("the number of its edits");
  LATTICED_RETURN_IF_ERROR(CheckBox(image.box));
  if (image.now < EditHistory::TimePoint() || image.commit_time < absl::UnixEpoch()) {
    return CannotBe("its times");
  }
  LATTICED_ASSIGN_OR_RETURN(const auto header, DecodeHeader(log.header));
  if (image.histories.size() < header.lattices.size() ||
      image.histories.size() > static_cast<size_t>(limits::kMaxLattices))
    return CannotBe("the number of its lattices");
  return SceneHistory::FromImages(std::move(image.histories)).status();
}

}  // namespace latticed
