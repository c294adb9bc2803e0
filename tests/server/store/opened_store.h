// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A store of a kind that a test is run with, in a folder of its own.
//
//   memory, shared_memory   nothing survives Reopen
//   sqlite
//   postgres                in a database of its own
#ifndef LATTICED_TESTS_SERVER_STORE_OPENED_STORE_H_
#define LATTICED_TESTS_SERVER_STORE_OPENED_STORE_H_

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "server/store/postgres/connection.h"
#include "server/store/store.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {

class OpenedStore {
 public:
  explicit OpenedStore(std::string kind);
  ~OpenedStore();

  Store& operator*() { return *store_; }
  Store* operator->() { return store_.get(); }
  const TemporaryFolder& folder() const { return folder_; }

  void Close() { store_.reset(); }
  void Open();
  void Reopen() {
    Close();
    Open();
  }

  // From now on the medium has no room for anything, or has it again.
  void SetFull(bool full);
  // From now on the medium takes for ever, or goes on.
  void SetStalled(bool stalled);

  // Appends a record and waits for the answer.
  absl::Status Append(std::string_view scene, uint64_t lsn, std::string record);
  // Waits until all that was appended to the scene before is answered.
  absl::Status Barrier(std::string_view scene) { return Append(scene, 0, ""); }
  // Waits until the store admits appends again.
  bool AdmitsAgain();

 private:
  void OpenPostgres();

  const std::string kind_;
  TemporaryFolder folder_;
  std::string url_;                       // of PostgreSQL's database
  std::unique_ptr<PgConnection> locker_;  // holds the locks of SetStalled
  std::unique_ptr<Store> store_;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_STORE_OPENED_STORE_H_
