// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Servers that share a store of a kind that a test is run with.
//
//   shared_memory, postgres
#ifndef LATTICED_TESTS_SERVER_STORE_STORE_FAMILY_H_
#define LATTICED_TESTS_SERVER_STORE_STORE_FAMILY_H_

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "server/store/store.h"

namespace latticed::testing {

class StoreFamily {
 public:
  virtual ~StoreFamily() = default;

  // A server with a store of its own, which is named so.
  virtual std::unique_ptr<Store> Join(const std::string& name) = 0;
  // The lease of a server is lost, as another one would do it.
  virtual void Fence(const std::string& name) = 0;
};

std::unique_ptr<StoreFamily> MakeStoreFamily(const std::string& kind);

// Appends a record and waits for the answer.
absl::Status AppendTo(Store& store, std::string_view scene, uint64_t lsn, std::string record);

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_STORE_STORE_FAMILY_H_
