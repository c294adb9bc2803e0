// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Calls about a mesh wait while the store deletes it. Other calls do not.
#include <array>
#include <future>
#include <memory>

#include "core/cpu/cpu_backend.h"
#include "tests/server/support/server_test.h"
#include "tests/server/support/slow_mesh_store.h"

namespace latticed::testing {
namespace {

TEST_F(ServerTest, CallsAboutAMeshThatIsBeingDeletedHoldNoQuickWorker) {
  const auto store = std::make_shared<SlowMeshStore>();
  store->PutAtOnce();
  StartServerOn(MakeCpuBackend({.threads = 1}), TestOptions(), store);
  v1::DeleteMeshRequest remove;
  remove.set_mesh(Upload(kGridObj));
  auto removed =
      std::async(std::launch::async, [&] { return Call(&Meshes::DeleteMesh, remove, nullptr); });
  store->AwaitCall();
  v1::ListMeshesResponse list;
  EXPECT_OK(Call(&Meshes::ListMeshes, {}, &list));
  EXPECT_EQ(list.meshes_size(), 1);

  v1::GetMeshRequest get;
  get.set_mesh(remove.mesh());
  std::array<std::future<absl::Status>, 4> waiting;  // as many as there may be quick workers
  for (auto& call : waiting) {
    call = std::async(std::launch::async, [&] { return Call(&Meshes::GetMesh, get, nullptr); });
  }
  for (auto& call : waiting) {
    EXPECT_EQ(call.wait_for(std::chrono::milliseconds(20)), std::future_status::timeout);
    EXPECT_OK(Call(&Infos::GetServerInfo, {}, nullptr));
  }

  store->LetGo();
  EXPECT_OK(removed.get());
  for (auto& call : waiting) {
    EXPECT_THAT(call.get(), StatusIs(absl::StatusCode::kNotFound));
  }
}

}  // namespace
}  // namespace latticed::testing
