// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Sends calls to the whole server, as bytes, through a channel without a socket: tests/fuzz/request_input.h. Calls may
// overlap. Each must end, none with INTERNAL or UNKNOWN, and another client must be answered after them.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <vector>

#include "tests/fuzz/fuzz_call.h"
#include "tests/fuzz/fuzz_server.h"
#include "tests/fuzz/message_mutator.h"
#include "tests/fuzz/request_input.h"

extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size);

namespace latticed::fuzz {
namespace {

// How long a stream may be silent before it is cancelled: a watch, or one that waits for what does not come.
constexpr absl::Duration kStreamPatience = absl::Milliseconds(3);
constexpr absl::Duration kPatience = absl::Seconds(10);  // for everything else

bool IsStream(const google::protobuf::MethodDescriptor* method) {
  return method->server_streaming() || method->client_streaming();
}

class Session {
 public:
  explicit Session(const web::ServerChannel& server) : server_(server) {}

  void Take(const RequestRecord& record) {
    const bool same = (record.head & RequestRecord::kSameCall) != 0 && !calls_.empty();
    if (!same) {
      calls_.push_back({MethodOf(record), nullptr});
      calls_.back().call = std::make_shared<FuzzCall>(calls_.back().method, &strand_, &ids_);
      calls_.back().call->Start(server_);
    }
    Entry& last = calls_.back();
    last.call->Send(record.bytes);
    if ((record.head & RequestRecord::kCancel) != 0) last.call->Cancel();
    if ((record.head & RequestRecord::kLeaveOpen) == 0) Finish(last);
  }

  void FinishAll() {
    for (Entry& entry : calls_) Finish(entry);
  }

  KnownIds& ids() { return ids_; }

 private:
  struct Entry {
    const google::protobuf::MethodDescriptor* method;
    std::shared_ptr<FuzzCall> call;
  };

  void Finish(Entry& entry) {
    entry.call->HalfClose();
    bool cancelled = false;
    while (!entry.call->ended()) {
      const bool may_cancel = IsStream(entry.method) && !cancelled;
      const bool watched = entry.method->name() == "Watch" && entry.call->updated();
      if (!(may_cancel && watched) && strand_.RunOne(may_cancel ? kStreamPatience : kPatience)) {
        continue;
      }
      if (!may_cancel) Fail(entry.method->full_name() + ": does not end");
      entry.call->Cancel();
      cancelled = true;
    }
  }

  const web::ServerChannel server_;
  Strand strand_;
  KnownIds ids_;
  std::vector<Entry> calls_;
};

// A message of one record is changed by fields, or blindly.
void MutateRecord(RequestRecord& record, Random& random) {
  const auto message = NewMessage(MethodOf(record)->input_type());
  if (Below(random, 8) != 0 && message->ParseFromString(record.bytes)) {
    MutateMessage(*message, random);
    record.bytes = message->SerializeAsString();
    return;
  }
  constexpr size_t kGrowth = 64;
  std::string& bytes = record.bytes;
  const size_t size = bytes.size();
  bytes.resize(size + kGrowth);
  bytes.resize(LLVMFuzzerMutate(reinterpret_cast<uint8_t*>(bytes.data()), size, bytes.size()));
}

void MutateRecords(std::vector<RequestRecord>& records, Random& random) {
  const size_t action = Below(random, 16);
  const size_t at = records.empty() ? 0 : Below(random, records.size());
  const auto place = records.begin() + static_cast<std::ptrdiff_t>(at);
  if (records.empty() || action < 3) {
    const auto& added = Templates()[Below(random, Templates().size())];
    records.insert(place, added.begin(), added.end());
  } else if (action == 3) {
    records.erase(place);
  } else if (action == 4) {
    std::swap(*place, records[Below(random, records.size())]);
  } else if (action == 5) {
    place->head = static_cast<uint16_t>(place->head ^ (0x20U << Below(random, 3)));
  } else if (action == 6) {
    place->head = static_cast<uint16_t>(Below(random, RequestRecord::kHeads));
  } else if (action == 7) {
    const RequestRecord again = *place;
    records.insert(place, again);
  } else {
    MutateRecord(*place, random);
  }
}

}  // namespace
}  // namespace latticed::fuzz

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  latticed::fuzz::SetOptions(argc, argv);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using latticed::fuzz::FuzzServer;
  FuzzServer& server = FuzzServer::Get();
  server.Begin();
  latticed::fuzz::Session session(server.channel());
  session.ids()["@mesh"] = server.mesh();
  for (const auto& record :
       latticed::fuzz::ReadRecords({reinterpret_cast<const char*>(data), size})) {
    session.Take(record);
  }
  session.FinishAll();
  server.End();
  return 0;
}

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size,
                                          unsigned int seed) {
  using namespace latticed::fuzz;
  Random random(seed);
  std::vector<RequestRecord> records = ReadRecords({reinterpret_cast<const char*>(data), size});
  do {
    MutateRecords(records, random);
  } while (Below(random, 3) == 0);
  const std::string input = WriteRecords(records);
  if (input.size() > max_size) return LLVMFuzzerMutate(data, size, max_size);
  std::memcpy(data, input.data(), input.size());
  return input.size();
}
