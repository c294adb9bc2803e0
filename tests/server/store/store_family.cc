// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/server/store/store_family.h"

#include <future>
#include <stdexcept>
#include <utility>

#include "server/store/shared_memory_store.h"

namespace latticed::testing {
namespace {

class SharedMemoryFamily : public StoreFamily {
 public:
  std::unique_ptr<Store> Join(const std::string& name) override {
    return std::make_unique<SharedMemoryStore>(memory_, name);
  }
  void Fence(const std::string& name) override { memory_->Fence(name); }

 private:
  const std::shared_ptr<SharedMemory> memory_ = std::make_shared<SharedMemory>();
};

}  // namespace

std::unique_ptr<StoreFamily> MakeStoreFamily(const std::string& kind) {
  if (kind == "shared_memory") return std::make_unique<SharedMemoryFamily>();
  throw std::invalid_argument(kind);
}

absl::Status AppendTo(Store& store, std::string_view scene, uint64_t lsn, std::string record) {
  const auto answer = std::make_shared<std::promise<absl::Status>>();
  store.Append(scene, lsn, std::move(record),
               [answer](const absl::Status& status) { answer->set_value(status); });
  return answer->get_future().get();
}

}  // namespace latticed::testing
