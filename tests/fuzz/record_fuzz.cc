// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Records of a scene's log over a lattice of 4^3 control points: size in 16 bits, little-endian, then the record, one
// after the other. Each does what it says or ends the log, and leads to a history as history_checks.h wants it.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "core/ffd/history/edit_history.h"
#include "server/store/records/scene_codec.h"
#include "server/store/records/scene_log.pb.h"
#include "tests/fuzz/history_checks.h"
#include "tests/fuzz/message_mutator.h"

extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size);

namespace {

using latticed::fuzz::Below;

constexpr size_t kMostRecordBytes = 0xFFFF;

std::vector<std::string> Split(std::string_view input) {
  std::vector<std::string> records;
  while (input.size() >= 2) {
    const size_t size = static_cast<uint8_t>(input[0]) + 256u * static_cast<uint8_t>(input[1]);
    records.emplace_back(input.substr(2, size));
    input.remove_prefix(std::min(input.size(), 2 + size));
  }
  return records;
}
std::string Join(const std::vector<std::string>& records) {
  std::string input;
  for (const std::string& record : records) {
    input += static_cast<char>(record.size() & 0xFF);
    input += static_cast<char>(record.size() >> 8);
    input += record;
  }
  return input;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  constexpr size_t kMostRecords = 32;  // keeps the time of an input near a millisecond
  latticed::EditHistory history(latticed::fuzz::FirstLattice());
  auto records = Split({reinterpret_cast<const char*>(data), size});
  records.resize(std::min(records.size(), kMostRecords));
  for (const std::string& bytes : records) {
    const auto record = latticed::DecodeRecord(bytes);
    if (!record.ok()) return 0;
    const std::string encoded = latticed::EncodeRecord(*record);
    const auto again = latticed::DecodeRecord(encoded);
    if (!again.ok()) std::abort();
    if (!latticed::fuzz::SameBits(latticed::EncodeRecord(*again), encoded)) std::abort();
    if (!history.ApplyRecord(record->edit).ok()) return 0;
  }
  latticed::fuzz::CheckHistory(std::move(history));
  return 0;
}

// Most changes are of one field of one record.
extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size,
                                          unsigned int seed) {
  latticed::fuzz::Random random(seed);
  auto records = Split({reinterpret_cast<const char*>(data), size});
  if (records.empty() || Below(random, 8) == 0) return LLVMFuzzerMutate(data, size, max_size);
  const size_t at = Below(random, records.size());
  latticed::store::Record record;
  if (!record.ParseFromString(records[at])) return LLVMFuzzerMutate(data, size, max_size);
  switch (Below(random, 6)) {
    case 0:
      records.erase(records.begin() + static_cast<std::ptrdiff_t>(at));
      break;
    case 1:
      records.insert(records.begin() + static_cast<std::ptrdiff_t>(at), records[at]);
      break;
    default:
      latticed::fuzz::MutateMessage(record, random);
      records[at] = record.SerializeAsString();
  }
  const std::string input = Join(records);
  if (input.size() > max_size || std::ranges::any_of(records, [](const std::string& r) {
        return r.size() > kMostRecordBytes;
      })) {
    return LLVMFuzzerMutate(data, size, max_size);
  }
  std::memcpy(data, input.data(), input.size());
  return input.size();
}
