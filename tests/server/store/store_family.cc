// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/server/store/store_family.h"

#include <future>
#include <stdexcept>
#include <utility>

#include "server/store/postgres_store.h"
#include "server/store/shared_memory_store.h"
#include "tests/server/store/postgres_server.h"
#include "tests/support/temporary_folder.h"

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

// Renewed every half a second. A busy machine keeps nobody from renewing it for longer.
constexpr absl::Duration kLease = absl::Seconds(2);

class PostgresFamily : public StoreFamily {
 public:
  std::unique_ptr<Store> Join(const std::string& name) override {
    absl::StatusOr<std::unique_ptr<Store>> opened =
        OpenPostgresStore({.url_file = folder_.Write("url", url_),
                           .mesh_store = folder_.Path("meshes"),
                           .name = name,
                           .lease = kLease});
    if (!opened.ok()) throw std::runtime_error(opened.status().ToString());
    return *std::move(opened);
  }
  void Fence(const std::string& name) override {
    ExecuteSql(url_, "UPDATE latticed.session SET fenced = true WHERE name = '" + name + "'");
  }

 private:
  const TemporaryFolder folder_;
  const std::string url_ = PostgresServer::Shared().NewDatabase();
};

}  // namespace

std::unique_ptr<StoreFamily> MakeStoreFamily(const std::string& kind) {
  if (kind == "shared_memory") return std::make_unique<SharedMemoryFamily>();
  if (kind == "postgres") return std::make_unique<PostgresFamily>();
  throw std::invalid_argument(kind);
}

absl::Status AppendTo(Store& store, std::string_view scene, uint64_t lsn, std::string record) {
  const auto answer = std::make_shared<std::promise<absl::Status>>();
  store.Append(scene, lsn, std::move(record),
               [answer](const absl::Status& status) { answer->set_value(status); });
  return answer->get_future().get();
}

}  // namespace latticed::testing
