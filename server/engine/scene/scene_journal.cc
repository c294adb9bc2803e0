// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/scene/scene_journal.h"

#include <new>

#include "core/base/catch_bad_alloc.h"
#include "server/store/store_errors.h"

namespace latticed {

absl::Status SceneJournal::Admit() const {
  if (store_ == nullptr) return absl::OkStatus();
  if (is_broken()) return error::StoreFailed("edits before this one could not be written");
  return store_->Admit();
}

void SceneJournal::Append(uint64_t lsn, const SceneRecord& record, Then then) {
  std::string bytes = EncodeRecord(record);
  ++records_;
  bytes_ += bytes.size();
  Post(lsn, std::move(bytes), std::move(then));
}

void SceneJournal::PutSnapshot(uint64_t lsn, const SceneImage& image) {
  std::string bytes = EncodeImage(image);  // first: without memory for it, a later edit tries again
  records_ = bytes_ = 0;
  store_->PutSnapshot(scene_, lsn, std::move(bytes));
}

void SceneJournal::Wait(Then then) { Post(0, "", std::move(then)); }

void SceneJournal::Post(uint64_t lsn, std::string record, Then then) {
  Store::Done done = [state = state_, then = std::move(then)](const absl::Status& durable) {
    if (!durable.ok()) state->broken = true;
    const auto answer = [&then](const absl::Status& status) {
      return CatchBadAlloc("the answer to an edit", [&] {
        then(status);
        return absl::OkStatus();
      });
    };
    if (const absl::Status given = answer(durable); !given.ok()) {
      state->broken = true;  // what is stored may not be published
      answer(absl::AbortedError(given.message())).IgnoreError();
    }
    --state->pending;
  };
  ++state_->pending;
  try {
    store_->Append(scene_, lsn, std::move(record), std::move(done));
  } catch (const std::bad_alloc&) {
    --state_->pending;
    throw;
  }
}

}  // namespace latticed
