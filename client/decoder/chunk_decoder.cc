// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/decoder/chunk_decoder.h"

#include <algorithm>
#include <array>
#include <vector>

#include "client/decoder/attribute_reader.h"
#include "client/decoder/chunk_layout.h"
#include "client/decoder/lanes/lane_kernel.h"
#include "client/decoder/symbol_table.h"

namespace latticed::decoder {
namespace {

using lane_kernel::kLanes;
using lane_kernel::PointLanes;
using lane_kernel::SymbolLane;

constexpr uint32_t kDifference = 0, kWrap = 1, kCanonicalOctahedron = 3;

bool ReadPrediction(ByteReader& in, uint32_t transform) {
  return in.Byte() == kDifference && in.Byte() == transform;
}

}  // namespace

struct ChunkDecoder::Workspace {
  std::array<NarrowTable, kLanes> position_tables, normal_tables;
  WideTable wide;
  KnownConnectivity known;
  std::vector<uint16_t> position_rows, normal_rows;
  std::vector<ChunkJob*> order;  // descending by points

  // Of the group that is decoded.
  size_t count = 0;  // of lanes
  std::array<ChunkJob*, kLanes> jobs;
  std::array<SymbolLane, kLanes> positions, normals;
  std::array<uint32_t, kLanes> spans;  // of positions
  PointLanes points;

  void Begin(const ChunkForm& form, uint32_t most_points);
  bool ReadPositions(ByteReader& in, const ChunkForm& form, uint32_t chunk_points);
  bool ReadNormals(ByteReader& in, const ChunkForm& form, uint32_t chunk_points);
  // Reads a chunk into the next lane, unless it is refused.
  void Read(const ChunkForm& form, ChunkJob& job);
  // Sets `decoded` to false where the bytes do not end as they must.
  void DecodeSymbols(std::span<const SymbolLane> lanes);
  void Finish();
};

void ChunkDecoder::Workspace::Begin(const ChunkForm& form, uint32_t most_points) {
  count = 0;
  const size_t numbers = size_t{most_points} * kLanes;
  if (position_rows.size() < 3 * numbers) position_rows.resize(3 * numbers);
  const bool has_normals = form.normal_bits > 0;
  if (has_normals && normal_rows.size() < 2 * numbers) normal_rows.resize(2 * numbers);
  points = PointLanes();
  points.position_rows = position_rows.data();
  points.normal_rows = has_normals ? normal_rows.data() : nullptr;
  points.normal_bits = form.normal_bits;
}

bool ChunkDecoder::Workspace::ReadPositions(ByteReader& in, const ChunkForm& form,
                                            uint32_t chunk_points) {
  SymbolLane& lane = positions[count];
  lane.out = position_rows.data() + count;
  uint32_t largest = 0;
  if (!ReadPrediction(in, kWrap)) return false;
  if (!ReadSymbols(in, 3, chunk_points, &position_tables[count], &wide, &lane, &largest)) {
    return false;
  }
  const auto least = in.Plain<uint32_t>(), most = in.Plain<uint32_t>();
  if (!in.ok() || least > most || most >> form.position_bits != 0) return false;
  const uint32_t span = most - least + 1;
  points.least[count] = static_cast<uint16_t>(least);
  points.span[count] = static_cast<uint16_t>(span);
  if (largest >= span) return false;
  spans[count] = span;
  return true;
}

bool ChunkDecoder::Workspace::ReadNormals(ByteReader& in, const ChunkForm& form,
                                          uint32_t chunk_points) {
  SymbolLane& lane = normals[count];
  lane.out = normal_rows.data() + count;
  uint32_t largest = 0;
  if (!ReadPrediction(in, kCanonicalOctahedron)) return false;
  if (!ReadSymbols(in, 2, chunk_points, &normal_tables[count], &wide, &lane, &largest)) {
    return false;
  }
  const uint32_t top = OctahedralTop(form.normal_bits);
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

void ChunkDecoder::Workspace::DecodeSymbols(std::span<const SymbolLane> lanes) {
  std::array<SymbolLane, kLanes> coded;
  std::array<ChunkJob*, kLanes> owners;
  size_t running = 0;
  for (size_t k = 0; k < count; ++k) {
    if (lanes[k].table == nullptr) continue;  // decoded already
    owners[running] = jobs[k];
    coded[running++] = lanes[k];
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
    Unwrap(position_rows.data() + k, jobs[k]->points, spans[k]);
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

ChunkDecoder::ChunkDecoder() : workspace_(std::make_unique<Workspace>()) {}
ChunkDecoder::~ChunkDecoder() = default;

bool ChunkDecoder::Decode(const ChunkForm& form, std::span<ChunkJob> jobs) {
  std::vector<ChunkJob*>& order = workspace_->order;
  order.clear();
  for (ChunkJob& job : jobs) {
    job.decoded = false;
    order.push_back(&job);
  }
  // Lanes of a group then end at about the same time.
  std::sort(order.begin(), order.end(),
            [](const ChunkJob* a, const ChunkJob* b) { return a->points > b->points; });
  for (size_t first = 0; first < order.size(); first += kLanes) {
    workspace_->Begin(form, order[first]->points);
    const size_t end = std::min(first + kLanes, order.size());
    for (size_t i = first; i < end; ++i) workspace_->Read(form, *order[i]);
    workspace_->Finish();
  }
  return std::all_of(jobs.begin(), jobs.end(), [](const ChunkJob& job) { return job.decoded; });
}

}  // namespace latticed::decoder
