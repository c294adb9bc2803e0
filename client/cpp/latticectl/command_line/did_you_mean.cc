// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/command_line/did_you_mean.h"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

namespace latticed::client {
namespace {

constexpr int kMostDistance = 2;

}  // namespace

int EditDistance(std::string_view a, std::string_view b) {
  std::vector<int> row(b.size() + 1);  // distances from the first i characters of a
  std::iota(row.begin(), row.end(), 0);
  for (size_t i = 0; i < a.size(); ++i) {
    int diagonal = std::exchange(row[0], static_cast<int>(i) + 1);
    for (size_t j = 0; j < b.size(); ++j) {
      const int substituted = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({substituted, diagonal + 1, row[j] + 1});
    }
  }
  return row.back();
}

std::string DidYouMean(std::string_view word, std::span<const std::string> candidates) {
  const auto letters =
      static_cast<int>(std::ranges::count_if(word, [](char c) { return c != '-'; }));
  if (letters == 0) return "";
  const auto begins = [word](const std::string& name) { return name.starts_with(word); };
  const auto longer = std::ranges::find_if(candidates, begins);
  if (longer != candidates.end()) return *longer;
  const int most = std::min(kMostDistance, letters / 2);
  const auto distance = [word](const std::string& name) { return EditDistance(word, name); };
  const auto nearest = std::ranges::min_element(candidates, {}, distance);
  return nearest != candidates.end() && distance(*nearest) <= most ? *nearest : "";
}

}  // namespace latticed::client
