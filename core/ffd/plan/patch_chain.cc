// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/plan/patch_chain.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>

namespace latticed {
namespace {

constexpr double kGrid = 16383;
// Squared: the part of the longest edge that another one must have to come first.
constexpr double kLeastPart2 = 1.0 / 256;
// Bits of a key below the cost.
constexpr int kColumnBits = 7;
constexpr int32_t kColumnMask = (1 << kColumnBits) - 1;
static_assert(3 * limits::kPatchesPerChunk <= kColumnMask);

// The square as the bits of a float, which compare as squares do.
inline int32_t Square(float x) { return std::bit_cast<int32_t>(x * x); }

// Bits of a step by three integers up to 2^14: the bit width of the largest square, which is the exponent of its float
// (rounding does not change it). So compilers turn a loop of this into instructions that every machine has.
inline uint32_t Bits(float x, float y, float z) {
  constexpr int32_t kExponentBits = 23, kNoBits = 126;  // the exponent of 1/2
  const int32_t largest =
      std::max(std::max(Square(x), Square(y)), std::max(Square(z), kNoBits << kExponentBits));
  return static_cast<uint32_t>((largest >> kExponentBits) - kNoBits);
}

}  // namespace

PatchChain::PatchChain(const SplitMesh& split, const Bounds& mesh_bounds)
    : split_(split), origin_(mesh_bounds.min) {
  const Vec3d extent = mesh_bounds.extent();
  const double longest = std::max({extent.x, extent.y, extent.z});
  if (longest > 0) scale_ = kGrid / longest;
  candidates_.reserve(split.pieces.size());
}

void PatchChain::AddPiece() {
  const auto& vertex = split_.pieces[candidates_.size()].vertex;
  Candidate& candidate = candidates_.emplace_back();
  std::array<Vec3d, 3> corner, side;
  for (size_t c = 0; c < 3; ++c) corner[c] = split_.vertices[vertex[c]].world;
  for (size_t c = 0; c < 3; ++c) {
    side[c] = corner[(c + 1) % 3] - corner[c];
    const Vec3d at = scale_ * (corner[c] - origin_);
    for (int axis = 0; axis < 3; ++axis) {
      candidate.corners[c][static_cast<size_t>(axis)] =
          static_cast<uint16_t>(static_cast<int>(std::min(std::max(0.0, at[axis]), kGrid) + 0.5));
    }
  }
  std::array<double, 3> length2{};
  std::array<bool, 3> is_obtuse{};
  std::array<uint32_t, 3> bits{};
  for (size_t c = 0; c < 3; ++c) {
    length2[c] = Dot(side[c], side[c]);
    is_obtuse[c] = Dot(side[c], side[(c + 2) % 3]) > 0;
    const auto &a = candidate.corners[c], &b = candidate.corners[(c + 1) % 3];
    bits[c] = Bits(static_cast<float>(a[0] - b[0]), static_cast<float>(a[1] - b[1]),
                   static_cast<float>(a[2] - b[2]));
  }
  const double longest2 = std::max({length2[0], length2[1], length2[2]});
  for (size_t c = 0; c < 3; ++c) {
    const size_t next = (c + 1) % 3;
    const bool lies_over = !is_obtuse[c] && !is_obtuse[next];
    const bool fits = (lies_over && length2[c] >= kLeastPart2 * longest2) || length2[c] == longest2;
    candidate.inner_cost[c] = fits ? static_cast<uint8_t>(2 * bits[c] + bits[next]) : kForbidden;
  }
}

void PatchChain::Append(std::span<const uint32_t> pieces, std::vector<ChainedPiece>& chain) {
  open_.count = pieces.size();
  for (size_t p = 0; p < pieces.size(); ++p) {
    const Candidate& candidate = candidates_[pieces[p]];
    open_.place[p] = p;
    for (size_t c = 0; c < 3; ++c) {
      const size_t column = 3 * p + c;
      for (size_t axis = 0; axis < 3; ++axis) {
        open_.at[axis][column] = candidate.corners[c][axis];
      }
      open_.key[column] = candidate.inner_cost[c] << kColumnBits | static_cast<int32_t>(column);
    }
  }
  while (open_.count > 0) {
    const auto column = static_cast<uint32_t>(LeastKey() & kColumnMask);
    const uint32_t p = column / 3, first = column % 3;
    chain.push_back({pieces[p], first});
    last_ = candidates_[pieces[p]].corners[(first + 2) % 3];
    open_.Remove(p);
  }
}

int32_t PatchChain::LeastKey() const {
  // After nothing, the first patch is as good as any.
  if (!last_.has_value()) return std::min({open_.key[0], open_.key[1], open_.key[2]});
  const auto x = static_cast<float>((*last_)[0]), y = static_cast<float>((*last_)[1]),
             z = static_cast<float>((*last_)[2]);
  int32_t least = std::numeric_limits<int32_t>::max();
  for (size_t column = 0; column < 3 * open_.count; ++column) {
    const uint32_t bits =
        Bits(open_.at[0][column] - x, open_.at[1][column] - y, open_.at[2][column] - z);
    least = std::min(least, open_.key[column] + static_cast<int32_t>(bits << kColumnBits));
  }
  return least;
}

void PatchChain::Open::Remove(size_t piece) {
  --count;
  const size_t to = place[piece];
  const auto last = static_cast<size_t>(key[3 * count] & kColumnMask) / 3;
  for (size_t c = 0; c < 3; ++c) {
    for (auto& axis : at) axis[3 * to + c] = axis[3 * count + c];
    key[3 * to + c] = key[3 * count + c];
  }
  place[last] = to;
}

}  // namespace latticed
