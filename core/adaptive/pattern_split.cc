// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/adaptive/pattern_split.h"

#include <cstdlib>

namespace latticed {
namespace {

SplitPoint Middle(const SplitPoint& p, const SplitPoint& q) {
  return {(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (p[2] + q[2]) / 2};
}

class PatchSplitter {
 public:
  explicit PatchSplitter(const PatternKey& key) : key_(key) {}

  void Split(const SplitTriangle& t) {
    std::array<bool, 3> is_split;  // side s joins corners s and (s + 1) % 3
    SplitTriangle middle;
    for (size_t s = 0; s < 3; ++s) {
      is_split[s] = Weight(t[s], t[Next(s)]) > int64_t{kSplitDenominator} * kSplitDenominator;
      middle[s] = Middle(t[s], t[Next(s)]);
    }
    switch (is_split[0] + is_split[1] + is_split[2]) {
      case 0:
        triangles_.push_back(t);
        break;
      case 1:
        SplitOne(t, middle, is_split[0] ? 0 : is_split[1] ? 1 : 2);
        break;
      case 2:
        SplitTwo(t, middle, !is_split[0] ? 0 : !is_split[1] ? 1 : 2);
        break;
      default:
        Split({t[0], middle[0], middle[2]});
        Split({middle[0], t[1], middle[1]});
        Split({middle[2], middle[1], t[2]});
        Split(middle);
    }
  }
  std::vector<SplitTriangle> Take() { return std::move(triangles_); }

 private:
  static size_t Next(size_t side) { return (side + 1) % 3; }

  int64_t Weight(const SplitPoint& p, const SplitPoint& q) const {
    int64_t sum = 0;
    for (size_t e = 0; e < 3; ++e) {
      const int64_t product = int64_t{q[e] - p[e]} * (q[Next(e)] - p[Next(e)]);
      sum += (key_.sparse ? -product : std::abs(product)) * (int64_t{1} << (2 * key_.levels[e]));
    }
    return sum;
  }

  void SplitOne(const SplitTriangle& t, const SplitTriangle& middle, size_t side) {
    const SplitPoint &p = t[side], &q = t[Next(side)], &r = t[Next(Next(side))];
    Split({p, middle[side], r});
    Split({middle[side], q, r});
  }

  void SplitTwo(const SplitTriangle& t, const SplitTriangle& middle, size_t whole_side) {
    const SplitPoint &p = t[whole_side], &q = t[Next(whole_side)], &r = t[Next(Next(whole_side))];
    const SplitPoint &qr = middle[Next(whole_side)], &rp = middle[Next(Next(whole_side))];
    Split({rp, qr, r});
    const int64_t from_p = Weight(p, qr), from_q = Weight(q, rp);
    if (from_p < from_q || (from_p == from_q && p > q)) {
      Split({p, q, qr});
      Split({p, qr, rp});
    } else {
      Split({p, q, rp});
      Split({q, qr, rp});
    }
  }

  const PatternKey key_;
  std::vector<SplitTriangle> triangles_;
};

}  // namespace

std::vector<SplitTriangle> SplitPatch(const PatternKey& key) {
  PatchSplitter splitter(key);
  splitter.Split(
      {{{kSplitDenominator, 0, 0}, {0, kSplitDenominator, 0}, {0, 0, kSplitDenominator}}});
  return splitter.Take();
}

}  // namespace latticed
