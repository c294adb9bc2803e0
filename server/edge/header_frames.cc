// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/edge/header_frames.h"

#include <dlfcn.h>
#include <grpc/slice.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <unordered_map>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "core/base/limits.h"
#include "core/base/mutex.h"
#include "server/edge/header_probe.h"

struct grpc_metadata_batch;

namespace grpc_core {

// As gRPC 1.51 declares it, as far as names and arguments of what is replaced go. Each connection has
// one, whose calls come one after the other. Visible, or the library would not see it.
class __attribute__((visibility("default"))) HPackParser {
 public:
  enum class Boundary : uint8_t { kNone, kEndOfHeaders, kEndOfStream };
  enum class Priority : uint8_t { kNone, kIncluded };
  struct LogInfo {
    uint32_t stream_id;
    uint8_t type;
    bool is_client;
  };
  static_assert(sizeof(LogInfo) == 8);

  ~HPackParser();
  void BeginFrame(grpc_metadata_batch* metadata, uint32_t most_bytes, Boundary boundary,
                  Priority priority, LogInfo log_info);
  absl::Status Parse(const grpc_slice& slice, bool is_last);
};

}  // namespace grpc_core

namespace latticed {
namespace {

using grpc_core::HPackParser;

constexpr char kEnd[] = "_ZN9grpc_core11HPackParserD1Ev";
constexpr char kBeginFrame[] =
    "_ZN9grpc_core11HPackParser10BeginFrameEP19grpc_metadata_batchjNS0_8BoundaryENS0_8PriorityE"
    "NS0_7LogInfoE";
constexpr char kParse[] = "_ZN9grpc_core11HPackParser5ParseERK10grpc_sliceb";

template <class Function>
Function* GrpcsOwn(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

// Of a server's connections.
std::atomic<bool> frames_begin_here = false, frames_are_parsed_here = false;

// Without a write, which all threads would wait for, where it is set.
void Set(std::atomic<bool>& flag) {
  if (!flag.load(std::memory_order_relaxed)) flag = true;
}

// Of frames that have not ended, which come in pieces.
class OpenFrames {
 public:
  // What has come of the parser's frame with this piece.
  size_t Add(const HPackParser* parser, size_t bytes, bool last) ABSL_LOCKS_EXCLUDED(mutex_) {
    if (last && open_.load() == 0) return bytes;
    const MutexLock lock(&mutex_);
    const auto found = bytes_.find(parser);
    const size_t all = bytes + (found == bytes_.end() ? 0 : found->second);
    if (!last) {
      bytes_.insert_or_assign(parser, all);
    } else if (found != bytes_.end()) {
      bytes_.erase(found);
    }
    open_ = bytes_.size();
    return all;
  }
  void Forget(const HPackParser* parser) ABSL_LOCKS_EXCLUDED(mutex_) {
    if (open_.load() == 0) return;
    const MutexLock lock(&mutex_);
    bytes_.erase(parser);
    open_ = bytes_.size();
  }

 private:
  std::atomic<size_t> open_ = 0;  // bytes_.size(), 1 or more for whoever has an entry
  Mutex mutex_;
  std::unordered_map<const HPackParser*, size_t> bytes_ ABSL_GUARDED_BY(mutex_);
};

OpenFrames& Open() {
  static auto* const open = new OpenFrames;  // gRPC's threads may outlive static objects
  return *open;
}

}  // namespace

bool HeadersAreBounded() {
  static const bool bounded =
      SendHeader([] { return frames_begin_here.load() && frames_are_parsed_here.load(); });
  return bounded;
}

}  // namespace latticed

namespace grpc_core {

HPackParser::~HPackParser() {
  static const auto own = latticed::GrpcsOwn<void(HPackParser*)>(latticed::kEnd);
  latticed::Open().Forget(this);
  own(this);
}

void HPackParser::BeginFrame(grpc_metadata_batch* metadata, uint32_t most_bytes, Boundary boundary,
                             Priority priority, LogInfo log_info) {
  static const auto own =
      latticed::GrpcsOwn<void(HPackParser*, grpc_metadata_batch*, uint32_t, Boundary, Priority,
                              LogInfo)>(latticed::kBeginFrame);
  latticed::Open().Forget(this);  // of one that had its address
  if (!log_info.is_client) {
    latticed::Set(latticed::frames_begin_here);
    most_bytes = std::min(most_bytes, latticed::limits::kMaxHeaderBytes);
    // Of a frame without metadata, which is of no call, gRPC says the contrary: that it ends the header
    // where it does not. With this it is an error where a field does not end.
    if (metadata != nullptr && boundary == Boundary::kNone) most_bytes = 0;
    if (metadata == nullptr || boundary == Boundary::kNone) boundary = Boundary::kEndOfHeaders;
  }
  own(this, metadata, most_bytes, boundary, priority, log_info);
}

absl::Status HPackParser::Parse(const grpc_slice& slice, bool is_last) {
  static const auto own =
      latticed::GrpcsOwn<absl::Status(HPackParser*, const grpc_slice&, bool)>(latticed::kParse);
  latticed::Set(latticed::frames_are_parsed_here);
  constexpr size_t kMost = size_t{2} * latticed::limits::kMaxHeaderBytes;
  if (latticed::Open().Add(this, GRPC_SLICE_LENGTH(slice), is_last) > kMost) {
    return absl::ResourceExhaustedError("the frame of a header is too long");
  }
  return own(this, slice, is_last);
}

}  // namespace grpc_core
