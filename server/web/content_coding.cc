// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/web/content_coding.h"

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"

namespace latticed::web {
namespace {

// Where a client likes both as much, the first is sent: Brotli's copy is the smaller one.
constexpr std::array<ContentCoding, 2> kCodings = {{{"br", ".br"}, {"gzip", ".gz"}}};

using Weights = std::map<std::string, double>;  // by coding, in lower case

// The weight of "gzip;q=0.5". It is 0 where the weight cannot be read, so that the coding is not used.
double WeightIn(const std::vector<std::string>& parameters) {
  for (size_t i = 1; i < parameters.size(); ++i) {
    const std::string parameter = absl::AsciiStrToLower(absl::StripAsciiWhitespace(parameters[i]));
    double weight = 0;
    if (!parameter.starts_with("q=")) continue;
    return absl::SimpleAtod(parameter.substr(2), &weight) && weight >= 0 && weight <= 1 ? weight
                                                                                        : 0;
  }
  return 1;
}

Weights WeightsIn(std::string_view accept_encoding) {
  Weights weights;
  for (const auto piece : absl::StrSplit(std::string(accept_encoding), ',')) {
    const std::vector<std::string> parameters = absl::StrSplit(piece, ';');
    const auto name = absl::StripAsciiWhitespace(parameters[0]);
    if (!name.empty()) weights[absl::AsciiStrToLower(name)] = WeightIn(parameters);
  }
  return weights;
}

// The weight of a coding: its own, or that of "*", which stands for all that are not named.
double WeightOf(std::string_view name, const Weights& weights) {
  auto found = weights.find(std::string(name));
  if (found == weights.end()) found = weights.find("*");
  return found == weights.end() ? 0 : found->second;
}

}  // namespace

std::vector<ContentCoding> AcceptedCodings(std::string_view accept_encoding) {
  const Weights weights = WeightsIn(accept_encoding);
  const auto identity = weights.find("identity");  // a client that does not name it likes it least
  const double least = identity == weights.end() ? 0 : identity->second;
  std::vector<ContentCoding> accepted;
  for (const ContentCoding& coding : kCodings) {
    const double weight = WeightOf(coding.name, weights);
    if (weight > 0 && weight >= least) accepted.push_back(coding);
  }
  std::ranges::stable_sort(accepted, std::ranges::greater(), [&](const ContentCoding& coding) {
    return WeightOf(coding.name, weights);
  });
  return accepted;
}

}  // namespace latticed::web
