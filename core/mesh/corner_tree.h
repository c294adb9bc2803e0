// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The corners of a plane polygon that may lie in an ear, found by triangle: a balanced k-d tree.
//
//   CornerTree tree(points);           // built once, with no corner in it
//   tree.Add(corner); …                // and Remove
//   tree.FindIn(a, b, c, test, tests)  // a corner for which `test` holds, else kNone
//
// A polygon of up to kLeafCorners corners is one leaf. FindIn counts in `tests` the nodes and corners that it looks at:
// a few dozen where corners do not crowd along the edges of the triangle.
//
// Layout   a heap: the children of node k are 2k + 1 and 2k + 2
// Threads  one at a time; the points must outlive the tree
#ifndef LATTICED_CORE_MESH_CORNER_TREE_H_
#define LATTICED_CORE_MESH_CORNER_TREE_H_

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <vector>

namespace latticed {

struct PlanePoint {
  double x = 0, y = 0;
  friend bool operator==(const PlanePoint&, const PlanePoint&) = default;
};

// Twice the signed area of abc; positive when counter-clockwise.
inline double Orient(PlanePoint a, PlanePoint b, PlanePoint c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

class CornerTree {
 public:
  static constexpr uint32_t kNone = ~uint32_t{0};
  static constexpr size_t kLeafCorners = 15;

  explicit CornerTree(const std::vector<PlanePoint>& points) : points_(points) {
    size_t leaves = 1;
    while (points.size() > leaves * kLeafCorners) leaves *= 2;
    first_leaf_ = leaves - 1;
    nodes_.resize(2 * leaves - 1);
    leaf_of_.resize(points.size());
    in_tree_.resize(points.size());
    order_.resize(points.size());
    std::iota(order_.begin(), order_.end(), 0u);
    Build(0, 0, static_cast<uint32_t>(points.size()));
  }

  void Add(uint32_t corner) { Count(corner, true); }
  void Remove(uint32_t corner) { Count(corner, false); }

  // Leaves out corners that are farther than kMargin from the triangle's box, or farther than kSlack from the inner
  // side of an edge (as a doubled area). The triangle is counter-clockwise, coordinates are of the unit box.
  template <typename Test>
  uint32_t FindIn(PlanePoint a, PlanePoint b, PlanePoint c, const Test& test,
                  uint64_t& tests) const {
    const PlanePoint low{std::min({a.x, b.x, c.x}) - kMargin, std::min({a.y, b.y, c.y}) - kMargin};
    const PlanePoint high{std::max({a.x, b.x, c.x}) + kMargin, std::max({a.y, b.y, c.y}) + kMargin};
    std::array<size_t, kMaxDepth + 2> stack;
    size_t depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
      const size_t k = stack[--depth];
      const Node& node = nodes_[k];
      ++tests;
      if (node.corners == 0) continue;
      if (nodes_.size() > 1 && (node.low.x > high.x || node.high.x < low.x || node.low.y > high.y ||
                                node.high.y < low.y || IsOutside(node, a, b) ||
                                IsOutside(node, b, c) || IsOutside(node, c, a))) {
        continue;
      }
      if (k < first_leaf_) {
        stack[depth++] = 2 * k + 2;
        stack[depth++] = 2 * k + 1;
        continue;
      }
      for (uint32_t i = node.begin; i < node.end; ++i) {
        ++tests;
        if (in_tree_[order_[i]] && test(order_[i])) return order_[i];
      }
    }
    return kNone;
  }

 private:
  static constexpr size_t kMaxDepth = 32;
  static constexpr double kMargin = 1e-6;
  static constexpr double kSlack = 1e-13;

  struct Node {
    PlanePoint low, high;         // of all corners under the node, in the tree or not
    uint32_t corners = 0;         // those in the tree
    uint32_t begin = 0, end = 0;  // in order_
  };

  // Whether the whole box of a node is to the right of the line ab.
  static bool IsOutside(const Node& node, PlanePoint a, PlanePoint b) {
    const PlanePoint leftmost{b.y >= a.y ? node.low.x : node.high.x,
                              b.x >= a.x ? node.high.y : node.low.y};
    return Orient(a, b, leftmost) < -kSlack;
  }

  void Build(size_t k, uint32_t begin, uint32_t end) {
    Node& node = nodes_[k];
    node.begin = begin;
    node.end = end;
    node.low = node.high = points_[order_[begin]];
    for (uint32_t i = begin; i < end; ++i) {
      const PlanePoint p = points_[order_[i]];
      node.low = {std::min(node.low.x, p.x), std::min(node.low.y, p.y)};
      node.high = {std::max(node.high.x, p.x), std::max(node.high.y, p.y)};
    }
    if (k >= first_leaf_) {
      for (uint32_t i = begin; i < end; ++i) leaf_of_[order_[i]] = static_cast<uint32_t>(k);
      return;
    }
    const uint32_t middle = begin + (end - begin) / 2;
    const bool wide = node.high.x - node.low.x >= node.high.y - node.low.y;
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                     [&](uint32_t i, uint32_t j) {
                       return wide ? points_[i].x < points_[j].x : points_[i].y < points_[j].y;
                     });
    Build(2 * k + 1, begin, middle);
    Build(2 * k + 2, middle, end);
  }

  void Count(uint32_t corner, bool added) {
    in_tree_[corner] = added;
    for (size_t k = leaf_of_[corner];; k = (k - 1) / 2) {
      added ? ++nodes_[k].corners : --nodes_[k].corners;
      if (k == 0) return;
    }
  }

  const std::vector<PlanePoint>& points_;
  size_t first_leaf_ = 0;
  std::vector<Node> nodes_;
  std::vector<uint32_t> order_, leaf_of_;
  std::vector<uint8_t> in_tree_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_CORNER_TREE_H_
