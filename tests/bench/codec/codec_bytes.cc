// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/codec/codec_bytes.h"

#include <algorithm>
#include <string>

#include "core/base/status_macros.h"
#include "core/codec/draco_decode.h"
#include "core/codec/draco_writer.h"
#include "tests/bench/codec/row_order.h"
#include "tests/support/encode_chunk.h"

namespace latticed::bench {
namespace {

using Stream = std::vector<uint8_t>;

bool HoldsIntegers(const Stream& stream, const QuantisedVertices& v) {
  const auto decoded = DecodeDracoChunkIntegers(stream);
  if (!decoded.ok()) return false;
  const auto normal = [&](const uint8_t* plane, size_t p) {
    return v.normal_bits <= 8 ? plane[p] : plane[2 * p] | uint32_t{plane[2 * p + 1]} << 8;
  };
  for (size_t p = 0; p < v.point_count; ++p) {
    const uint32_t* position = &decoded->positions[3 * p];
    const uint32_t* its_normal = &decoded->normals[2 * p];
    if (position[0] != v.x[p] || position[1] != v.y[p] || position[2] != v.z[p] ||
        its_normal[0] != normal(v.s, p) || its_normal[1] != normal(v.t, p)) {
      return false;
    }
  }
  return true;
}

// Past a number of 7 bits a byte, the lowest first; `at` moves on.
size_t TakeVarint(const Stream& stream, size_t& at) {
  size_t value = 0;
  for (int shift = 0;; shift += 7) {
    const uint8_t byte = stream[at++];
    value |= size_t{byte & 0x7Fu} << shift;
    if (byte < 0x80) return value;
  }
}

// Where symbols of the raw scheme end that begin at `at`, their bits: a table of probabilities, of
// one to three bytes each or of runs of absent symbols, and the states.
size_t EndOfRawSymbols(const Stream& stream, size_t at) {
  constexpr uint8_t kRun = 3;
  size_t next = at + 1;
  const size_t symbols = TakeVarint(stream, next);
  for (size_t symbol = 0; symbol < symbols; ++symbol) {
    const uint8_t byte = stream[next++];
    if (byte % 4 == kRun) {
      symbol += byte / 4;
    } else {
      next += byte % 4;
    }
  }
  const size_t bytes = TakeVarint(stream, next);
  return next + bytes;
}

// Whether libdraco picked its tagged scheme for positions or normals of a cloud. A head takes 17
// bytes and 6 an attribute; prediction, its transform and that symbols are coded, which libdraco's
// always are, come before the scheme; the bounds of positions, 8 bytes, come after their symbols.
bool HasTaggedSymbols(const Stream& stream) {
  constexpr size_t kHead = 17, kAttribute = 6, kScheme = 3, kBounds = 8;
  const size_t positions = kHead + 2 * kAttribute;
  if (stream[positions + kScheme] == 0) return true;
  const size_t normals = EndOfRawSymbols(stream, positions + kScheme + 1) + kBounds;
  return stream[normals + kScheme] == 0;
}

absl::StatusOr<std::vector<Stream>> Written(std::span<const QuantisedVertices> vertices,
                                            double range) {
  static const auto* writer = new DracoWriter;
  std::vector<Stream> streams(vertices.size());
  const absl::Status status = writer->Encode(vertices, range, nullptr, streams);
  if (!status.ok()) return status;
  return streams;
}

std::vector<QuantisedVertices> ToVertices(std::span<const std::vector<uint8_t>> chunks,
                                          const ViewSpec& spec) {
  std::vector<QuantisedVertices> vertices;
  for (const auto& bytes : chunks) {
    vertices.push_back(QuantisedVertices::FromBytes(bytes, bytes.size() / BytesPerPoint(spec),
                                                    spec.position_bits, spec.normal_bits));
  }
  return vertices;
}

double Ratio(size_t a, size_t b) { return static_cast<double>(a) / static_cast<double>(b); }

}  // namespace

// A group of chunks at a time, as a backend has it.
absl::StatusOr<CodecBytes> CodecBytes::Count(const Scenario& scenario, const ViewSpec& spec) {
  const auto view = MakeView(scenario, Pipeline::kFused, spec, 1);
  const size_t batch = DracoWriter().batch();
  CodecBytes sums;
  for (size_t first = 0; first < scenario.all_chunks.size(); first += batch) {
    std::vector<std::vector<uint8_t>> chunks(std::min(batch, scenario.all_chunks.size() - first));
    for (size_t i = 0; i < chunks.size(); ++i) {
      const uint32_t chunk = scenario.all_chunks[first + i];
      chunks[i].resize(ChunkPoints(*scenario.plan, chunk, spec.segments) * BytesPerPoint(spec));
      LATTICED_RETURN_IF_ERROR(view->Read(chunk, chunks[i]));
    }
    LATTICED_RETURN_IF_ERROR(sums.AddGroup(chunks, spec, scenario.box.range));
  }
  return sums;
}

double CodecBytes::more_than_libdraco() const { return Ratio(ours, libdraco) - 1; }

double CodecBytes::saved_by_serpentine() const { return 1 - Ratio(ours, row_by_row); }

absl::Status CodecBytes::AddGroup(std::span<const std::vector<uint8_t>> chunks,
                                  const ViewSpec& spec, double range) {
  std::vector<std::vector<uint8_t>> rows;
  for (const auto& bytes : chunks) rows.push_back(RowByRow(bytes, spec));
  const auto vertices = ToVertices(chunks, spec);
  LATTICED_ASSIGN_OR_RETURN(const auto streams, Written(vertices, range));
  LATTICED_ASSIGN_OR_RETURN(const auto row_streams, Written(ToVertices(rows, spec), range));
  for (const Stream& stream : row_streams) row_by_row += stream.size();
  for (size_t i = 0; i < streams.size(); ++i) {
    LATTICED_RETURN_IF_ERROR(AddChunk(vertices[i], streams[i], range));
  }
  return absl::OkStatus();
}

absl::Status CodecBytes::AddChunk(const QuantisedVertices& vertices, const Stream& stream,
                                  double range) {
  static const auto* reference = MakeReferenceEncoder().release();
  if (!HoldsIntegers(stream, vertices)) {
    return absl::InternalError("a stream decodes to other integers");
  }
  LATTICED_ASSIGN_OR_RETURN(const auto theirs, testing::EncodePoints(*reference, vertices, range));
  const bool tagged = HasTaggedSymbols(theirs);
  const int64_t more = static_cast<int64_t>(stream.size()) - static_cast<int64_t>(theirs.size());
  points += vertices.point_count;
  ours += stream.size();
  libdraco += theirs.size();
  ++chunks;
  if (more > 0) ++larger, larger_bytes += static_cast<size_t>(more);
  if (tagged) ++tagged_chunks;
  (tagged ? more_at_tagged : more_elsewhere) += more;
  return absl::OkStatus();
}

}  // namespace latticed::bench
