// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/server_env.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>
#include <thread>
#include <utility>

#include "absl/time/clock.h"
#include "core/base/limits.h"
#include "fmt/format.h"
#include "server/base/process_memory.h"
#include "server/base/random_id.h"
#include "server/base/telemetry.h"
#include "server/rpc/call.h"
#include "server/rpc/call_counts.h"
#include "server/stores/scene_registry.h"
#include "server/stores/upload_store.h"

namespace latticed {
namespace {

// A worker parses or plans on one thread. More workers would only compete with the backend's threads.
constexpr unsigned kMinWorkers = 2;
constexpr unsigned kMaxWorkers = 8;

// Threads that evaluate and encode views. The last one takes only short turns. Each also uses the backend's own
// threads.
constexpr int kRenderWorkers = 3;

std::string HostName() {
  std::array<char, 256> name{};
  if (gethostname(name.data(), name.size() - 1) != 0) return "unknown";
  return name.data();
}

void LogEviction(const Scene& scene, uint64_t bytes) {
  LogEvent(spdlog::level::info, "scene evicted: another needs its memory",
           {{"scene", scene.id()}, {"bytes", fmt::to_string(bytes)}});
}

}  // namespace

ServerEnv::ServerEnv(Options options_in, std::vector<std::unique_ptr<Backend>> backends_in,
                     Authenticator authenticator_in)
    : options(std::move(options_in)),
      boot_id(NewRandomId()),
      node(options.node.empty() ? HostName() : options.node),
      peer_key("latticed-peer-" + NewRandomId()),
      token_key(NewRandomId()),
      start_time(absl::Now()),
      calls(std::make_unique<CallCounts>()),
      backends(std::move(backends_in)),
      authenticator(std::move(authenticator_in)),
      memory(std::make_shared<MemoryBudget>(options.memory_bytes)),
      requests(
          std::make_shared<MemoryBudget>(options.memory_bytes / limits::kWaitingRequestsShare)),
      replies(std::make_shared<MemoryBudget>(options.memory_bytes / limits::kUntakenRepliesShare)),
      uploads(std::make_unique<UploadStore>(memory)),
      scenes(std::make_unique<SceneRegistry>(
          &backend(), kRenderWorkers,
          SceneRegistry::Options{.max_scenes = static_cast<size_t>(options.max_scenes),
                                 .memory = memory,
                                 .on_tick =
                                     [this, heap = HeapTrimmer()]() mutable {
                                       uploads->DropExpired();
                                       heap.Tick();
                                       LogRefusalSums(*calls, absl::Now());
                                     },
                                 .on_evict = LogEviction})),
      workers_(std::make_unique<boost::asio::thread_pool>(
          std::clamp(std::thread::hardware_concurrency(), kMinWorkers, kMaxWorkers))) {}

ServerEnv::~ServerEnv() { workers_->join(); }

void ServerEnv::Post(std::function<void()> work) { boost::asio::post(*workers_, std::move(work)); }

}  // namespace latticed
