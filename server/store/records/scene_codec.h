// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The records of a scene's log, and images of its history, as bytes (scene_log.proto).
//
// Errors   kDataLoss for bytes that no encoder made. What decodes may still not fit a history: EditHistory checks that
// Threads  pure functions
#ifndef LATTICED_SERVER_STORE_RECORDS_SCENE_CODEC_H_
#define LATTICED_SERVER_STORE_RECORDS_SCENE_CODEC_H_

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "core/ffd/history/edit_history_image.h"
#include "core/ffd/history/edit_record.h"
#include "core/ffd/plan/quantisation_box.h"

namespace latticed {

// One record of a scene's log. Its times are on the clock of the scene, which starts when that is made.
struct SceneRecord {
  EditRecord edit;
  std::optional<QuantisationBox> box;  // if the batch made a new one
  absl::Time commit_time;
};

struct SceneImage {
  std::vector<EditHistoryImage> histories;  // one per lattice
  QuantisationBox box;
  std::chrono::steady_clock::time_point now;  // of the last record, on the scene's clock
  absl::Time commit_time;                     // of the last record
};

[[nodiscard]] std::string EncodeRecord(const SceneRecord& record);
[[nodiscard]] absl::StatusOr<SceneRecord> DecodeRecord(std::string_view bytes);
[[nodiscard]] std::string EncodeImage(const SceneImage& image);
[[nodiscard]] absl::StatusOr<SceneImage> DecodeImage(std::string_view bytes);

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_RECORDS_SCENE_CODEC_H_
