// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/adaptive/kernel/run_buffer.h"

#include <algorithm>

namespace latticed::fused {

void RunBuffer::Clear() {
  patch_.clear();
  code_.clear();
  along_.clear();
  up_.clear();
}

size_t RunBuffer::Add(size_t patch, const PatternPlaces& places) {
  const size_t first = size();
  patch_.insert(patch_.end(), places.code.size(), static_cast<int32_t>(patch));
  code_.insert(code_.end(), places.code.begin(), places.code.end());
  along_.insert(along_.end(), places.along.begin(), places.along.end());
  up_.insert(up_.end(), places.up.begin(), places.up.end());
  return first;
}

void RunBuffer::Add(size_t patch, int32_t code, float along, float up) {
  patch_.push_back(static_cast<int32_t>(patch));
  code_.push_back(code);
  along_.push_back(along);
  up_.push_back(up);
}

void RunBuffer::Evaluate(const std::array<int, 3>& degree, const BoxPolynomial& box,
                         NormalMode normals, bool weighted) {
  const size_t count = size(), vectors = (count + kLanes - 1) / kLanes;
  padded_ = vectors * kLanes;
  // The last vector repeats its last point.
  patch_.resize(padded_, patch_.back());
  code_.resize(padded_, code_.back());
  along_.resize(padded_, along_.back());
  up_.resize(padded_, up_.back());
  if (memory_.size() < kComponents * padded_ + kLanes) {
    memory_.resize(kComponents * padded_ + kLanes);
  }
  const auto address = reinterpret_cast<uintptr_t>(memory_.data());
  const uintptr_t alignment = kLanes * sizeof(float);
  rows_ = memory_.data() + (alignment - address % alignment) % alignment / sizeof(float);
  if (weak_.size() < padded_) weak_.resize(padded_);

  RunArguments arguments{.degree = degree,
                         .box = &box,
                         .patches = &patches,
                         .normals = normals,
                         .points = {patch_.data(), code_.data(), along_.data(), up_.data()},
                         .scratch = {rows_, vectors},
                         .weak = weak_.data(),
                         .weak_count = 0,
                         .weights = weighted ? &weights : nullptr};
  weighted ? EvaluateWeightedRun(arguments) : EvaluateRun(arguments);
  weak_count_ = arguments.weak_count;
  patch_.resize(count);
  code_.resize(count);
  along_.resize(count);
  up_.resize(count);
}

}  // namespace latticed::fused
