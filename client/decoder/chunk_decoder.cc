// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/decoder/chunk_decoder.h"

#include <algorithm>
#include <array>
#include <vector>

#include "client/decoder/attribute_reader.h"
#include "client/decoder/chunk_layout.h"
#include "client/decoder/lanes/lane_kernel.h"
#include "client/decoder/meshopt/meshopt_reader.h"
#include "client/decoder/symbol_table.h"
#include "core/codec/draco_container.h"
#include "core/codec/octahedral.h"

namespace latticed::decoder {
namespace {

using draco_format::kCanonicalOctahedron;
using draco_format::kDifference;
using draco_format::kWrap;
using lane_kernel::kLanes;
using lane_kernel::PointLanes;
using lane_kernel::SymbolLane;

constexpr int kMostPositionBits = 16, kMostNormalBits = 12;

bool IsWritten(const ChunkForm& form) {
  return form.position_bits >= 1 && form.position_bits <= kMostPositionBits &&
         form.normal_bits >= 0 && form.normal_bits <= kMostNormalBits;
}

}  // namespace

struct ChunkDecoder::Workspace {
  // The symbols of one attribute of all lanes.
  struct Attribute {
    uint32_t components;
    uint32_t transform;
    std::array<NarrowTable, kLanes> tables{};
    std::array<SymbolLane, kLanes> lanes{};
    std::vector<uint16_t> rows{};
  };

  Attribute positions{.components = 3, .transform = kWrap};
  Attribute normals{.components = 2, .transform = kCanonicalOctahedron};
  WideTable wide;
  KnownConnectivity known;
  std::vector<ChunkJob*> order;  // that may be decoded

  // Of the group that is decoded.
  size_t count = 0;  // of lanes
  std::array<ChunkJob*, kLanes> jobs;
  std::array<uint32_t, kLanes> spans;  // of positions
  PointLanes points;

  void Begin(const ChunkForm& form, uint32_t most_points);
  // Reads the symbols of the next lane, and sets the largest that may occur.
  bool ReadAttribute(ByteReader& in, uint32_t chunk_points, Attribute& attribute,
                     uint32_t* largest);
  bool ReadPositions(ByteReader& in, const ChunkForm& form, uint32_t chunk_points);
  bool ReadNormals(ByteReader& in, const ChunkForm& form, uint32_t chunk_points);
  // Reads a chunk into the next lane, unless it is refused.
  void Read(const ChunkForm& form, ChunkJob& job);
  // Sets `decoded` to false where the bytes do not end as they must.
  void DecodeSymbols(const Attribute& attribute);
  void Finish();
  // Decodes the chunks of `order`.
  void DecodeDraco(const ChunkForm& form);
};

void ChunkDecoder::Workspace::Begin(const ChunkForm& form, uint32_t most_points) {
  count = 0;
  points = PointLanes();
  const auto rows_of = [&](Attribute& attribute) {
    const size_t numbers = attribute.components * kLanes * size_t{most_points};
    if (attribute.rows.size() < numbers) attribute.rows.resize(numbers);
    return attribute.rows.data();
  };
  points.position_rows = rows_of(positions);
  if (form.normal_bits > 0) points.normal_rows = rows_of(normals);
  points.normal_bits = form.normal_bits;
}

bool ChunkDecoder::Workspace::ReadAttribute(ByteReader& in, uint32_t chunk_points,
                                            Attribute& attribute, uint32_t* largest) {
  if (in.Byte() != kDifference || in.Byte() != attribute.transform) return false;
  SymbolLane& lane = attribute.lanes[count];
  lane.out = attribute.rows.data() + count;
  return ReadSymbols(in, attribute.components, chunk_points, &attribute.tables[count], &wide, &lane,
                     largest);
}

bool ChunkDecoder::Workspace::ReadPositions(ByteReader& in, const ChunkForm& form,
                                            uint32_t chunk_points) {
  uint32_t largest = 0;
  if (!ReadAttribute(in, chunk_points, positions, &largest)) return false;
  const auto least = in.Plain<uint32_t>(), most = in.Plain<uint32_t>();
  if (!in.ok() || least > most || most >> form.position_bits != 0) return false;
  spans[count] = most - least + 1;
  points.least[count] = static_cast<uint16_t>(least);
  points.span[count] = static_cast<uint16_t>(spans[count]);
  return largest < spans[count];
}

bool ChunkDecoder::Workspace::ReadNormals(ByteReader& in, const ChunkForm& form,
                                          uint32_t chunk_points) {
  uint32_t largest = 0;
  if (!ReadAttribute(in, chunk_points, normals, &largest)) return false;
  const auto top = static_cast<uint32_t>(OctahedralMax(form.normal_bits));
  return in.Plain<uint32_t>() == top + 1 && in.Plain<uint32_t>() == top / 2 && largest <= top;
}

void ChunkDecoder::Workspace::Read(const ChunkForm& form, ChunkJob& job) {
  ByteReader in(job.stream.data(), job.stream.size());
  ChunkHead head;
  if (!ReadHead(in, form, job.points, &wide, &known, &head)) return;
  if (!ReadPositions(in, form, job.points)) return;
  if (form.normal_bits > 0 && !ReadNormals(in, form, job.points)) return;
  if (!ReadTail(in, form, head, job.stream.size())) return;
  points.points[count] = job.points;
  points.out[count] = job.out;
  jobs[count++] = &job;
}

void ChunkDecoder::Workspace::DecodeSymbols(const Attribute& attribute) {
  std::array<SymbolLane, kLanes> coded;
  std::array<ChunkJob*, kLanes> owners;
  size_t running = 0;
  for (size_t k = 0; k < count; ++k) {
    if (attribute.lanes[k].table == nullptr) continue;  // decoded already
    owners[running] = jobs[k];
    coded[running++] = attribute.lanes[k];
  }
  lane_kernel::DecodeSymbols(coded.data(), running);
  for (size_t r = 0; r < running; ++r) {
    if (coded[r].table == nullptr) owners[r]->decoded = false;
  }
}

void ChunkDecoder::Workspace::Finish() {
  for (size_t k = 0; k < count; ++k) jobs[k]->decoded = true;
  DecodeSymbols(positions);
  if (points.normal_rows != nullptr) DecodeSymbols(normals);
  for (size_t k = 0; k < count; ++k) {
    if (spans[k] <= lane_kernel::kMostLaneSpan) continue;
    Unwrap(positions.rows.data() + k, jobs[k]->points, spans[k]);
    points.span[k] = 0;
  }
  lane_kernel::WritePoints(points);
  for (size_t k = 0; k < count; ++k) {
    for (size_t axis = 0; axis < 3; ++axis) {
      jobs[k]->least[axis] = points.low[axis][k];
      jobs[k]->most[axis] = points.high[axis][k];
    }
  }
}

void ChunkDecoder::Workspace::DecodeDraco(const ChunkForm& form) {
  // Lanes of a group then end at about the same time.
  const auto is_larger = [](const ChunkJob* a, const ChunkJob* b) { return a->points > b->points; };
  std::partial_sort(order.begin(), order.end(), order.end(), is_larger);  // less code than sort
  for (size_t first = 0; first < order.size(); first += kLanes) {
    Begin(form, order[first]->points);
    const size_t end = std::min(first + kLanes, order.size());
    for (size_t i = first; i < end; ++i) Read(form, *order[i]);
    Finish();
  }
}

ChunkDecoder::ChunkDecoder() : workspace_(std::make_unique<Workspace>()) {}
ChunkDecoder::~ChunkDecoder() = default;

bool ChunkDecoder::Decode(const ChunkForm& form, std::span<ChunkJob> jobs) {
  std::vector<ChunkJob*>& order = workspace_->order;
  order.clear();
  for (ChunkJob& job : jobs) {
    job.decoded = false;
    if (IsWritten(form) && job.points > 0 && job.points <= kMostPoints) order.push_back(&job);
  }
  if (form.codec == Codec::kMeshopt) {
    for (ChunkJob* job : order) DecodeMeshopt(form, *job);
  } else {
    workspace_->DecodeDraco(form);
  }
  return std::all_of(jobs.begin(), jobs.end(), [](const ChunkJob& job) { return job.decoded; });
}

}  // namespace latticed::decoder
