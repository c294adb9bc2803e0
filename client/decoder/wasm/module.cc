// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The decoder as a WebAssembly module with SIMD128. It imports nothing. A caller
//
//   reserves memory for a batch: records, streams and points, each at a multiple of 4,
//   writes records and streams,
//   decodes, and reads records and points (own_decoder.ts in client/web/src/decode and client/node/src).
//
// Memory may grow with each call of Reserve, so views of it are made anew. A module is used by one thread.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "client/decoder/chunk_decoder.h"

extern "C" char __heap_base;  // from the linker: where memory is free

namespace {

using latticed::decoder::ChunkDecoder;
using latticed::decoder::ChunkForm;
using latticed::decoder::ChunkJob;
using latticed::decoder::Codec;

// A chunk: where its stream is, and where its points go.
struct Record {
  const uint8_t* stream;
  uint32_t stream_bytes;
  uint32_t points;
  uint16_t* out;
  uint32_t decoded;  // what follows is set if this is 1
  uint16_t least[3], most[3];
};
static_assert(sizeof(Record) == 32, "own_decoder.ts reads it");

// Never destroyed.
ChunkDecoder& Decoder() {
  static auto* const decoder = new ChunkDecoder();
  return *decoder;
}

}  // namespace

// Returns the address of so many bytes. What was there before is lost.
extern "C" [[clang::export_name("Reserve")]] uint8_t* Reserve(size_t bytes) {
  static uint8_t* memory = nullptr;
  static size_t size = 0;
  if (bytes > size) {
    size = std::max(bytes, 2 * size);
    memory = static_cast<uint8_t*>(operator new(size));
  }
  return memory;
}

extern "C" [[clang::export_name("Decode")]] void Decode(Record* records, size_t count, Codec codec,
                                                        int position_bits, int normal_bits) {
  static auto* const jobs = new std::vector<ChunkJob>();
  jobs->clear();
  for (size_t i = 0; i < count; ++i) {
    const Record& record = records[i];
    jobs->push_back({.stream = {record.stream, record.stream_bytes},
                     .points = record.points,
                     .out = record.out});
  }
  Decoder().Decode({.position_bits = position_bits, .normal_bits = normal_bits, .codec = codec},
                   *jobs);
  for (size_t i = 0; i < count; ++i) {
    const ChunkJob& job = (*jobs)[i];
    records[i].decoded = job.decoded ? 1 : 0;
    for (size_t axis = 0; axis < 3; ++axis) {
      records[i].least[axis] = job.least[axis];
      records[i].most[axis] = job.most[axis];
    }
  }
}

// Memory is only ever taken. What grows, at least doubles, so less is left behind than is in use.
void* operator new(size_t bytes) {
  constexpr uintptr_t kAlignment = 16, kPage = 64 << 10;
  static uintptr_t free_from = reinterpret_cast<uintptr_t>(&__heap_base);
  const uintptr_t begin = (free_from + kAlignment - 1) / kAlignment * kAlignment;
  const uintptr_t end = begin + bytes, size = __builtin_wasm_memory_size(0) * kPage;
  if (end < begin) __builtin_trap();
  if (end > size && __builtin_wasm_memory_grow(0, (end - size + kPage - 1) / kPage) == ~size_t{0})
    __builtin_trap();
  free_from = end;
  return reinterpret_cast<void*>(begin);
}
void operator delete(void*) noexcept {}
void operator delete(void*, size_t) noexcept {}
