// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A snapshot of a scene, as a backup may have it: it is refused, or leads to a history as history_checks.h wants it.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>
#include <utility>

#include "server/engine/scene/copied_history.h"
#include "server/store/records/header_codec.h"
#include "server/store/records/scene_codec.h"
#include "server/store/records/scene_log.pb.h"
#include "tests/fuzz/history_checks.h"
#include "tests/fuzz/message_mutator.h"

extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size);

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const std::string header =
      latticed::EncodeHeader({.lattices = {latticed::fuzz::FirstLattice()}});
  latticed::SceneLog log{.header = header,
                         .snapshot = std::string(reinterpret_cast<const char*>(data), size)};
  auto image = latticed::DecodeImage(log.snapshot);
  if (!image.ok()) return 0;
  const std::string encoded = latticed::EncodeImage(*image);
  const auto again = latticed::DecodeImage(encoded);
  if (!again.ok()) std::abort();
  if (!latticed::fuzz::SameBits(latticed::EncodeImage(*again), encoded)) std::abort();
  for (const auto& history : image->histories) log.snapshot_lsn += history.records;
  if (log.snapshot_lsn == 0 || !latticed::CheckCopied(log).ok()) return 0;
  for (auto& one : image->histories) {
    auto history = latticed::EditHistory::FromImage(std::move(one));
    if (!history.ok()) std::abort();
    latticed::fuzz::CheckHistory(*std::move(history));
  }
  return 0;
}

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size,
                                          unsigned int seed) {
  latticed::fuzz::Random random(seed);
  latticed::store::Image image;
  if (latticed::fuzz::Below(random, 8) == 0 ||
      !image.ParseFromArray(data, static_cast<int>(size))) {
    return LLVMFuzzerMutate(data, size, max_size);
  }
  do {
    latticed::fuzz::MutateMessage(image, random);
  } while (latticed::fuzz::Below(random, 3) == 0);
  if (image.ByteSizeLong() > max_size) return LLVMFuzzerMutate(data, size, max_size);
  const std::string input = image.SerializeAsString();
  std::memcpy(data, input.data(), input.size());
  return input.size();
}
