// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/measure/triangle_rule.h"

#include <cmath>
#include <numbers>

namespace latticed {
namespace {

struct Node {
  double at = 0, weight = 0;  // on [0, 1]
};

// The roots of the Legendre polynomial P_m by Newton's method.
std::vector<Node> GaussLegendre(int m) {
  constexpr int kSteps = 12;  // from these starts, five reach the last bit
  std::vector<Node> nodes;
  for (int i = 0; i < m; ++i) {
    double x = std::cos(std::numbers::pi * (i + 0.75) / (m + 0.5)), slope = 1;
    for (int step = 0; step < kSteps; ++step) {
      double before = 0, value = 1;
      for (int n = 1; n <= m; ++n) {
        const double next = ((2 * n - 1) * x * value - (n - 1) * before) / n;
        before = value;
        value = next;
      }
      slope = m * (x * value - before) / (x * x - 1);
      x -= value / slope;
    }
    nodes.push_back({0.5 * (1 - x), 1 / ((1 - x * x) * slope * slope)});
  }
  return nodes;
}

}  // namespace

std::vector<TriangleRulePoint> MakeTriangleRule(int m) {
  const std::vector<Node> nodes = GaussLegendre(m);
  std::vector<TriangleRulePoint> rule;
  for (const Node& s : nodes) {
    for (const Node& t : nodes) {
      const double b = t.at * (1 - s.at);
      rule.push_back({{1 - s.at - b, s.at, b}, 2 * s.weight * t.weight * (1 - s.at)});
    }
  }
  return rule;
}

}  // namespace latticed
