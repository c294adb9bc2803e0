// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Finds the word that was meant by a misspelt one.
//
//   distance   insertions, deletions and substitutions of a character         Levenshtein 1966
//   near       a distance of at most 2, and of at most half the word's letters; '-' is no letter
//
// Threads  pure
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_COMMAND_LINE_DID_YOU_MEAN_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_COMMAND_LINE_DID_YOU_MEAN_H_

#include <span>
#include <string>
#include <string_view>

namespace latticed::client {

[[nodiscard]] int EditDistance(std::string_view a, std::string_view b);

// Returns the first candidate that begins with `word`, else the nearest near one (the first of equals), else "".
[[nodiscard]] std::string DidYouMean(std::string_view word,
                                     std::span<const std::string> candidates);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_COMMAND_LINE_DID_YOU_MEAN_H_
