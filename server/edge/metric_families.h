// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Builds families of metrics.
//
//   MetricFamilies out;
//   out.Gauge("latticed_scenes", "Scenes.").Add(scenes.size());
//   out.Counter("latticed_edits_total", "Edits.").Add(applied, {{"result", "applied"}});
#ifndef LATTICED_SERVER_EDGE_METRIC_FAMILIES_H_
#define LATTICED_SERVER_EDGE_METRIC_FAMILIES_H_

#include <prometheus/metric_family.h>

#include <atomic>
#include <cstdint>
#include <deque>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "server/base/duration_histogram.h"

namespace latticed {

class MetricFamilies {
 public:
  using Labels = std::vector<prometheus::ClientMetric::Label>;

  // A family of a MetricFamilies, valid as long as that.
  class Family {
   public:
    explicit Family(prometheus::MetricFamily* family) : family_(family) {}

    Family& Add(double value, Labels labels = {}) {
      prometheus::ClientMetric& metric = NewMetric(std::move(labels));
      const bool counts = family_->type == prometheus::MetricType::Counter;
      (counts ? metric.counter.value : metric.gauge.value) = value;
      return *this;
    }
    Family& Add(uint64_t value, Labels labels = {}) {
      return Add(static_cast<double>(value), std::move(labels));
    }
    Family& Add(const std::atomic<uint64_t>& count, Labels labels = {}) {
      return Add(count.load(), std::move(labels));
    }
    Family& Add(const DurationHistogram& histogram, Labels labels) {
      const DurationHistogram::Reading reading = histogram.Read();
      auto& out = NewMetric(std::move(labels)).histogram;
      for (size_t i = 0; i < DurationHistogram::kBounds.size(); ++i) {
        out.sample_count += reading.counts[i];
        out.bucket.push_back({out.sample_count, DurationHistogram::kBounds[i]});
      }
      out.sample_count += reading.counts.back();
      out.sample_sum = reading.sum_seconds;
      return *this;
    }

   private:
    prometheus::ClientMetric& NewMetric(Labels labels) {
      prometheus::ClientMetric& metric = family_->metric.emplace_back();
      metric.label = std::move(labels);
      return metric;
    }

    prometheus::MetricFamily* family_;
  };

  Family Gauge(std::string name, std::string help) {
    return New(std::move(name), std::move(help), prometheus::MetricType::Gauge);
  }
  // A counter never falls; its name ends in _total.
  Family Counter(std::string name, std::string help) {
    return New(std::move(name), std::move(help), prometheus::MetricType::Counter);
  }
  Family Histogram(std::string name, std::string help) {
    return New(std::move(name), std::move(help), prometheus::MetricType::Histogram);
  }

  std::vector<prometheus::MetricFamily> Take() && {
    return {std::make_move_iterator(families_.begin()), std::make_move_iterator(families_.end())};
  }

 private:
  Family New(std::string name, std::string help, prometheus::MetricType type) {
    return Family(
        &families_.emplace_back(prometheus::MetricFamily{std::move(name), std::move(help), type}));
  }

  std::deque<prometheus::MetricFamily> families_;  // a deque: their addresses must not change
};

}  // namespace latticed

#endif  // LATTICED_SERVER_EDGE_METRIC_FAMILIES_H_
