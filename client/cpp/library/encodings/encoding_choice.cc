// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/library/encodings/encoding_choice.h"

#include <algorithm>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr double kMoreBytes = 0.2;  // of a point by meshopt
// The first probe fits what TCP sends at once. If it takes so long, the line is slow, and larger ones would keep it busy.
constexpr uint32_t kSmallProbe = 8 << 10, kLargeProbe = 256 << 10;
constexpr absl::Duration kSlow = absl::Milliseconds(10);

// The time of a call with a probe.
absl::StatusOr<absl::Duration> Probe(Client& client, uint32_t bytes) {
  const absl::Time begin = absl::Now();
  LATTICED_RETURN_IF_ERROR(client.GetServerInfo(bytes).status());
  return absl::Now() - begin;
}

// Bytes a second. The last of two large probes counts: TCP's windows have grown by then.
absl::StatusOr<double> MeasureLine(Client& client) {
  LATTICED_ASSIGN_OR_RETURN(const absl::Duration round_trip, Probe(client, 0));
  const auto rate = [round_trip](uint32_t bytes, absl::Duration time) {
    return bytes / absl::ToDoubleSeconds(std::max(time - round_trip, time / 10));
  };
  LATTICED_ASSIGN_OR_RETURN(absl::Duration time, Probe(client, kSmallProbe));
  if (time - round_trip > kSlow) return rate(kSmallProbe, time);
  for (int i = 0; i < 2; ++i) {
    LATTICED_ASSIGN_OR_RETURN(time, Probe(client, kLargeProbe));
  }
  return rate(kLargeProbe, time);
}

}  // namespace

EncodingChoice ChooseEncoding(double line_rate, const DecodeTimes& times) {
  const double extra = kMoreBytes / line_rate, saved = times.draco - times.meshopt;
  return {extra < saved ? v1::ENCODING_MESHOPT : v1::ENCODING_DRACO_POINTS,
          fmt::format("meshopt's {} bytes more a point take {:.1f} ns at {:.4g} MB/s, decoding "
                      "saves {:.1f} ns",
                      kMoreBytes, extra * 1e9, line_rate / 1e6, saved * 1e9)};
}

absl::StatusOr<EncodingChoice> ChooseEncoding(Client& client) {
  LATTICED_ASSIGN_OR_RETURN(const auto info, client.GetServerInfo());  // connects, too
  if (std::ranges::find(info.encodings(), v1::ENCODING_MESHOPT) == info.encodings().end()) {
    return EncodingChoice{v1::ENCODING_DRACO_POINTS, "the server has no meshopt"};
  }
  LATTICED_ASSIGN_OR_RETURN(const double line_rate, MeasureLine(client));
  return ChooseEncoding(line_rate, MeasuredDecodeTimes());
}

absl::StatusOr<std::string> ChooseOpenEncoding(Client& client, const std::string& scene,
                                               v1::ViewOptions& view) {
  if (view.encoding() != v1::ENCODING_UNSPECIFIED) return "";
  LATTICED_ASSIGN_OR_RETURN(const auto described, client.GetScene(scene));
  if (described.default_view().encoding() != v1::ENCODING_DRACO_POINTS) return "";
  LATTICED_ASSIGN_OR_RETURN(const EncodingChoice choice, ChooseEncoding(client));
  view.set_encoding(choice.encoding);
  return choice.reason;
}

}  // namespace latticed::client
