// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/library/patches/box_polynomials.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace latticed::client {
namespace {

constexpr size_t kMost = limits::kMaxDegree + 1;

size_t Terms(const std::array<int, 3>& degree) {
  return static_cast<size_t>((degree[0] + 1) * (degree[1] + 1) * (degree[2] + 1));
}

}  // namespace

BoxPolynomials::BoxPolynomials(const LatticeStructure& structure, const PatchPlanHeader& header)
    : degree_(structure.degree),
      size_(structure.size),
      terms_(Terms(structure.degree)),
      origin_(header.origin),
      has_outside_(header.patches_outside > 0) {
  const KnotPlanes planes(structure);
  uint32_t step = 1;
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<size_t>(a);
    spans_[axis] = planes.spans(a);
    steps_[axis] = step;
    step *= spans_[axis];
    for (uint32_t s = 0; s < spans_[axis]; ++s) {
      const int span = planes.knot_span(a, s);
      basis_[axis].push_back(MakeSpanBasis(structure.knots[axis], degree_[axis], span));
      first_[axis].push_back(span - degree_[axis]);
    }
  }
  coefficients_.resize(count() * 3 * terms_);
  conormals_.resize(count() * size_t{9});
  if (header.weighted) rest_.resize(count() * size_t{12});
  SetOutside(header);
  SetConormals(structure, planes);
  if (header.weighted) SetRest(structure, planes);
}

std::array<uint32_t, 3> BoxPolynomials::SpansOf(uint32_t box) const {
  const uint32_t cell = box - 1;
  return {cell % spans_[0], cell / steps_[1] % spans_[1], cell / steps_[2]};
}

void BoxPolynomials::Store(uint32_t box, size_t term, Vec3d coefficient) {
  for (int c = 0; c < 3; ++c) {
    coefficients_[(box * 3 + static_cast<size_t>(c)) * terms_ + term] =
        static_cast<float>(coefficient[c]);
  }
}

void BoxPolynomials::SetOutside(const PatchPlanHeader& header) {
  const Vec3d width = header.outside_upper - header.outside_lower;
  const Vec3d centre = 0.5 * header.outside_lower + 0.5 * header.outside_upper - origin_;
  Store(0, 0, centre);
  StoreRest(0, 0, centre);
  size_t term = 1;
  for (int a = 0; a < 3; ++a) {
    Vec3d along;
    along[a] = width[a];
    Store(0, term, along);
    StoreRest(0, static_cast<size_t>(a) + 1, along);
    term *= static_cast<size_t>(degree_[static_cast<size_t>(a)] + 1);
  }
}

void BoxPolynomials::StoreRest(uint32_t box, size_t row, Vec3d numbers) {
  if (rest_.empty()) return;
  for (int c = 0; c < 3; ++c) {
    rest_[box * size_t{12} + 3 * row + static_cast<size_t>(c)] = static_cast<float>(numbers[c]);
  }
}

void BoxPolynomials::SetRest(const LatticeStructure& structure, const KnotPlanes& planes) {
  for (uint32_t box = 1; box < count(); ++box) {
    const std::array<uint32_t, 3> spans = SpansOf(box);
    Vec3d centre = structure.frame.origin - origin_;
    for (int a = 0; a < 3; ++a) {
      const auto axis = static_cast<size_t>(a);
      const double begin = structure.domain_begin(a), range = structure.domain_end(a) - begin;
      const double lower = planes.lower(a, spans[axis]), upper = planes.upper(a, spans[axis]);
      const Vec3d edge = structure.frame.edges[axis];
      centre += ((0.5 * lower + 0.5 * upper - begin) / range) * edge;
      StoreRest(box, axis + 1, ((upper - lower) / range) * edge);
    }
    StoreRest(box, 0, centre);
  }
}

// Normals have no length, so the largest conormal becomes 1 long: products of small world units do not vanish.
void BoxPolynomials::SetConormals(const LatticeStructure& structure, const KnotPlanes& planes) {
  const std::array<Vec3d, 3>& edges = structure.frame.edges;
  const double sign = Dot(Cross(edges[0], edges[1]), edges[2]) < 0 ? -1 : 1;
  const auto conormal = [&](int a, uint32_t span) {
    const double width = planes.upper(a, span) - planes.lower(a, span);
    return edges[static_cast<size_t>(a)] *
           (sign * width / (structure.domain_end(a) - structure.domain_begin(a)));
  };
  double longest = 0;
  for (int a = 0; a < 3; ++a) {
    for (uint32_t s = 0; s < planes.spans(a); ++s)
      longest = std::max(longest, Norm(conormal(a, s)));
  }
  for (uint32_t box = 1; box < count(); ++box) {
    const std::array<uint32_t, 3> spans = SpansOf(box);
    for (int a = 0; a < 3; ++a) {
      const Vec3d n = conormal(a, spans[static_cast<size_t>(a)]) / longest;
      for (int c = 0; c < 3; ++c) {
        conormals_[box * size_t{9} + static_cast<size_t>(3 * a + c)] = static_cast<float>(n[c]);
      }
    }
  }
}

// One axis at a time. The first control point is subtracted before and added after, so that boxes whose control points
// coincide have derivatives of exactly 0.
void BoxPolynomials::Update(std::span<const Vec3d> control_points,
                            std::span<const uint32_t> boxes) {
  const auto [n0, n1, n2] =
      std::array{static_cast<size_t>(degree_[0] + 1), static_cast<size_t>(degree_[1] + 1),
                 static_cast<size_t>(degree_[2] + 1)};
  for (const uint32_t box : boxes) {
    const std::array<uint32_t, 3> spans = SpansOf(box);
    const SpanBasis &m0 = basis_[0][spans[0]], &m1 = basis_[1][spans[1]], &m2 = basis_[2][spans[2]];
    const auto control_point = [&](size_t r, size_t s, size_t t) {
      const int i = first_[0][spans[0]] + static_cast<int>(r),
                j = first_[1][spans[1]] + static_cast<int>(s),
                k = first_[2][spans[2]] + static_cast<int>(t);
      return control_points[static_cast<size_t>(i + size_[0] * (j + size_[1] * k))];
    };
    const Vec3d base = control_point(0, 0, 0);
    Vec3d by_0[kMost][kMost][kMost]{}, by_1[kMost][kMost][kMost]{};  // [t][s][a], [t][b][a]
    for (size_t t = 0; t < n2; ++t) {
      for (size_t s = 0; s < n1; ++s) {
        for (size_t r = 0; r < n0; ++r) {
          const Vec3d p = control_point(r, s, t) - base;
          for (size_t a = 0; a < n0; ++a) by_0[t][s][a] += m0[r][a] * p;
        }
        for (size_t b = 0; b < n1; ++b) {
          for (size_t a = 0; a < n0; ++a) by_1[t][b][a] += m1[s][b] * by_0[t][s][a];
        }
      }
    }
    size_t term = 0;
    for (size_t c = 0; c < n2; ++c) {
      for (size_t b = 0; b < n1; ++b) {
        for (size_t a = 0; a < n0; ++a, ++term) {
          Vec3d sum = term == 0 ? base - origin_ : Vec3d{};
          for (size_t t = 0; t < n2; ++t) sum += m2[t][c] * by_1[t][b][a];
          Store(box, term, sum);
        }
      }
    }
  }
}

// With |l_a| <= 1/2, a term C l_0^i l_1^j l_2^k is at most |C| / 2^(i + j + k), and its derivative by l_0 is at most
// 2 i times that.
BoxPolynomials::Reach BoxPolynomials::ReachOf(uint32_t box, size_t coordinate) const {
  const float* coefficient = &coefficients_[(box * 3 + coordinate) * terms_];
  const double centre = double{*coefficient};
  Reach reach;
  double radius = 0;
  for (int k = 0; k <= degree_[2]; ++k) {
    for (int j = 0; j <= degree_[1]; ++j) {
      for (int i = 0; i <= degree_[0]; ++i) {
        const int power = i + j + k;
        const double most = std::ldexp(std::abs(double{*coefficient++}), -power);
        reach.derivatives += 2 * power * most;
        if (power > 0) radius += most;
      }
    }
  }
  reach.lowest = centre - radius;
  reach.highest = centre + radius;
  return reach;
}

// A point lies between X and R. At one weight, the derivative by l_a is between those of X and R, too.
BoxPolynomials::Reach BoxPolynomials::WeightedReachOf(uint32_t box, size_t coordinate) const {
  Reach reach = ReachOf(box, coordinate);
  const float* rest = &rest_[box * size_t{12} + coordinate];  // of rows of three
  double radius = 0, slopes = 0;
  for (size_t row = 1; row <= 3; ++row) {
    radius += 0.5 * std::abs(double{rest[3 * row]});
    slopes += std::abs(double{rest[3 * row]});
  }
  const double lowest = double{*rest} - radius, highest = double{*rest} + radius;
  reach.offset = std::max(reach.highest - lowest, highest - reach.lowest);
  reach.derivatives = std::max(reach.derivatives, slopes);
  reach.lowest = std::min(reach.lowest, lowest);
  reach.highest = std::max(reach.highest, highest);
  return reach;
}

double BoxPolynomials::PositionError(std::span<const uint32_t> boxes) const {
  constexpr double kOfDiagonal = 1e-6;
  constexpr double kHalfPlace = 0.5 / kPlacesPerSpan;
  Vec3d derivatives, lowest, highest;
  for (size_t c = 0; c < 3; ++c) {
    const int axis = static_cast<int>(c);
    lowest[axis] = std::numeric_limits<double>::infinity();
    highest[axis] = -lowest[axis];
    const auto add = [&](uint32_t box) {
      const Reach reach = rest_.empty() ? ReachOf(box, c) : WeightedReachOf(box, c);
      derivatives[axis] = std::max(derivatives[axis], reach.derivatives + reach.offset);
      lowest[axis] = std::min(lowest[axis], reach.lowest);
      highest[axis] = std::max(highest[axis], reach.highest);
    };
    if (has_outside_) add(0);
    for (const uint32_t box : boxes) add(box);
  }
  const double everywhere = kOfDiagonal * Norm(highest - lowest);
  return Norm(kHalfPlace * derivatives + Vec3d{everywhere, everywhere, everywhere});
}

}  // namespace latticed::client
