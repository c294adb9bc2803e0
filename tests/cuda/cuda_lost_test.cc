// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A device that is lost for good. Each test runs in its own process, because a process never gets
// the device back. tests/server/devices/device_lost_test.cc tests how a server reacts.
#include <cstdlib>
#include <iostream>
#include <vector>

#include "core/base/error.h"
#include "cuda/cuda_backend.h"
#include "tests/cuda/cuda_test.h"
#include "tests/cuda/trap_kernel.h"

namespace latticed::testing {
namespace {

class CudaLost : public CudaTest {
 protected:
  CudaLost() : CudaTest(29) { GTEST_FLAG_SET(death_test_style, "threadsafe"); }

  // Prints for every call whether it reports the loss, then ends the process.
  [[noreturn]] void LoseDevice() {
    const ViewSpec spec{.segments = 4};
    auto backend = MakeCudaBackend({.memory_bytes = 64 * kMiB});
    auto target = (*backend)->Prepare(plan_, Pipeline::kFused);
    auto view = (*target)->CreateView(spec);
    const QuantisationBox box = BoxFor(*plan_, points_);
    const absl::Status before = (*view)->Evaluate(points_, box, AllChunks(*plan_));
    TrapDevice();
    std::vector<uint8_t> bytes(ChunkPoints(*plan_, 0, spec.segments) * BytesPerPoint(spec));
    Say("read", (*view)->Read(0, bytes));
    Say("evaluate", (*view)->Evaluate(points_, box, AllChunks(*plan_)));
    Say("view", (*target)->CreateView({.segments = 5}).status());
    Say("target", (*backend)->Prepare(plan_, Pipeline::kFused).status());
    view->reset(), target->reset(), backend->reset();
    std::exit(before.ok() ? 0 : 1);
  }

 private:
  static void Say(const char* what, const absl::Status& status) {
    const bool lost =
        absl::IsUnavailable(status) && error::DetailsOf(status).reason == "DEVICE_LOST";
    std::cerr << what << ": " << (lost ? "lost" : status.ToString()) << "; ";
  }
};

TEST_F(CudaLost, EveryCallSaysSoAndNoneCrashes) {
  EXPECT_EXIT(LoseDevice(), ::testing::ExitedWithCode(0),
              "read: lost; evaluate: lost; view: lost; target: lost; ");
}

}  // namespace
}  // namespace latticed::testing
