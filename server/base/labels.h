// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Labels of meshes and scenes, the filters of lists over them, and page sizes and tokens.
//
// Filter   "key=value" or "key", joined by commas, all of which must hold; empty takes all
// Errors   kInvalidArgument naming the field
// Threads  pure functions
#ifndef LATTICED_SERVER_BASE_LABELS_H_
#define LATTICED_SERVER_BASE_LABELS_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace latticed {

using Labels = std::map<std::string, std::string>;

// At most limits::kMaxLabels, keys [a-z0-9._-]{1,63}, values up to 255 bytes. `field` is "labels".
[[nodiscard]] absl::Status CheckLabels(const Labels& labels, std::string_view field);

class LabelFilter {
 public:
  [[nodiscard]] static absl::StatusOr<LabelFilter> Parse(std::string_view filter);
  [[nodiscard]] bool Matches(const Labels& labels) const;

 private:
  struct Term {
    std::string key;
    bool any_value = false;
    std::string value;
  };
  std::vector<Term> terms_;
};

// 0 is limits::kDefaultPageSize.
[[nodiscard]] absl::StatusOr<size_t> PageSize(int32_t page_size);

// What a page may still hold: a number of items, and limits::kMaxPageBytes in all, so that a reply fits in
// a message whatever labels its items have.
class PageRoom {
 public:
  explicit PageRoom(size_t items) : items_(items) {}
  // Whether an item of so many bytes fits on the page. The first item always does.
  [[nodiscard]] bool Take(size_t bytes);

 private:
  size_t items_;  // that still fit
  size_t bytes_ = 0;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_LABELS_H_
