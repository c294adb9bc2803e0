// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/base/labels.h"

#include <algorithm>

#include "absl/strings/str_split.h"
#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/utf8.h"
#include "fmt/format.h"

namespace latticed {
namespace {

// The most bytes of an invalid key or filter term that an error message repeats.
constexpr size_t kShownBytes = 64;

bool IsKey(std::string_view key) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' || c == '_' || c == '-';
  };
  return !key.empty() && key.size() <= limits::kMaxLabelKeyBytes &&
         std::all_of(key.begin(), key.end(), allowed);
}

}  // namespace

absl::Status CheckLabels(const Labels& labels, std::string_view field) {
  if (labels.size() > limits::kMaxLabels) {
    return error::OutOfRange(field, static_cast<double>(labels.size()), 0, limits::kMaxLabels);
  }
  for (const auto& [key, value] : labels) {
    if (!IsKey(key)) {
      return error::InvalidField(field,
                                 fmt::format("the key '{}' is not 1 to {} of a-z 0-9 . _ -",
                                             CutUtf8(key, kShownBytes), limits::kMaxLabelKeyBytes));
    }
    if (value.size() > limits::kMaxLabelValueBytes) {
      return error::InvalidField(
          field, fmt::format("the value of '{}' has {} bytes, allowed are {}", key, value.size(),
                             limits::kMaxLabelValueBytes));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<LabelFilter> LabelFilter::Parse(std::string_view filter) {
  LabelFilter result;
  if (filter.empty()) return result;
  const std::string text(filter);
  for (const auto piece : absl::StrSplit(text, ',')) {
    const std::string term(piece);
    const size_t equals = term.find('=');
    const std::string key = term.substr(0, equals);
    if (!IsKey(key)) {
      return error::InvalidField(
          "filter", fmt::format("'{}' is neither key=value nor key", CutUtf8(term, kShownBytes)));
    }
    const bool any_value = equals == std::string::npos;
    result.terms_.push_back({key, any_value, any_value ? "" : term.substr(equals + 1)});
  }
  return result;
}

bool LabelFilter::Matches(const Labels& labels) const {
  return std::all_of(terms_.begin(), terms_.end(), [&labels](const Term& term) {
    const auto found = labels.find(term.key);
    return found != labels.end() && (term.any_value || found->second == term.value);
  });
}

absl::StatusOr<size_t> PageSize(int32_t page_size) {
  if (page_size == 0) return size_t{limits::kDefaultPageSize};
  if (page_size < 0 || page_size > limits::kMaxPageSize) {
    return error::OutOfRange("page_size", page_size, 1, limits::kMaxPageSize);
  }
  return static_cast<size_t>(page_size);
}

bool PageRoom::Take(size_t bytes) {
  constexpr size_t kOverheadBytes = 4;  // tag and length of an item of the list
  if (items_ == 0 || (bytes_ > 0 && bytes_ + bytes + kOverheadBytes > limits::kMaxPageBytes)) {
    return false;
  }
  --items_;
  bytes_ += bytes + kOverheadBytes;
  return true;
}

}  // namespace latticed
