// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/sum/knot_refinement.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

namespace latticed {
namespace {

using Weights = std::array<double, 4>;

// The weights of control points span - degree … span in the blossom at `arguments`, of which there are `degree`. `span` is
// that of a non-empty knot span.
Weights Blossom(const AxisSpace& space, size_t span, std::span<const double> arguments) {
  Weights weights{1};
  for (size_t k = 1; k <= arguments.size(); ++k) {
    Weights next{};
    for (size_t i = 1; i <= k; ++i) {
      const double low = space.knots[span + i - k], high = space.knots[span + i];
      const double a = (arguments[k - 1] - low) / (high - low);
      next[i - 1] += weights[i - 1] * (1 - a);
      next[i] += weights[i - 1] * a;
    }
    weights = next;
  }
  return weights;
}

// The mean over all choices of source.degree of the arguments.
Weights RaisedBlossom(const AxisSpace& source, size_t span, const std::vector<double>& arguments) {
  Weights sum{};
  int choices = 0;
  for (size_t chosen = 0; chosen < (size_t{1} << arguments.size()); ++chosen) {
    std::vector<double> some;
    for (size_t k = 0; k < arguments.size(); ++k) {
      if ((chosen >> k & 1) != 0) some.push_back(arguments[k]);
    }
    if (some.size() != static_cast<size_t>(source.degree)) continue;
    const Weights one = Blossom(source, span, some);
    for (size_t i = 0; i < sum.size(); ++i) sum[i] += one[i];
    ++choices;
  }
  for (double& weight : sum) weight /= choices;
  return sum;
}

// The knot span that begins at `x`, or holds it.
size_t SpanAt(const AxisSpace& space, double x) {
  const auto after = std::upper_bound(space.knots.begin(), space.knots.end(), x);
  return static_cast<size_t>(after - space.knots.begin()) - 1;
}

// Where the control point's polynomial is taken: the beginning of a non-empty span of its support. Any gives the same point.
// One where the source is 0 gives 0 at once; else that with the middle of the point's knots, or next to it, has the smallest
// weights.
double ChosenSpan(const AxisSpace& source, const AxisSpace& target, size_t point) {
  const auto n = static_cast<size_t>(target.degree);
  double middle = 0;
  for (size_t k = 1; k <= n; ++k) middle += target.knots[point + k] / static_cast<double>(n);
  double chosen = 0, least = std::numeric_limits<double>::infinity();
  for (size_t j = point; j <= point + n; ++j) {
    const double low = target.knots[j], high = target.knots[j + 1];
    if (!(low < high) || low < target.begin() || high > target.end()) continue;
    if (low < source.begin() || low >= source.end()) return low;
    const double distance = std::max({low - middle, middle - high, 0.0});
    if (distance >= least) continue;
    chosen = low;
    least = distance;
  }
  return chosen;
}

}  // namespace

std::vector<RefinedPoint> Refine(const AxisSpace& source, const AxisSpace& target) {
  std::vector<RefinedPoint> points(static_cast<size_t>(target.size()));
  for (size_t p = 0; p < points.size(); ++p) {
    const double at = ChosenSpan(source, target, p);
    if (at < source.begin() || at >= source.end()) continue;
    std::vector<double> arguments(
        target.knots.begin() + static_cast<std::ptrdiff_t>(p) + 1,
        target.knots.begin() + static_cast<std::ptrdiff_t>(p) + 1 + target.degree);
    // Near ones first: equal spaces then give weights 0 and 1 exactly.
    std::ranges::stable_sort(arguments, {}, [at](double x) { return std::abs(x - at); });
    const size_t span = SpanAt(source, at);
    points[p] = {static_cast<int>(span) - source.degree, source.degree + 1,
                 RaisedBlossom(source, span, arguments)};
  }
  return points;
}

}  // namespace latticed
