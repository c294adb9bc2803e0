// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/geometry/weights_source.h"

#include <utility>
#include <vector>

#include "client/cpp/latticectl/geometry/point_table.h"
#include "core/base/status_macros.h"
#include "core/mesh/little_endian.h"

namespace latticed::client {

absl::StatusOr<std::string> ReadWeights(const std::string& file) {
  LATTICED_ASSIGN_OR_RETURN(const std::vector<double> numbers, ReadColumn(file));
  // A request holds at most 1 MiB.
  constexpr size_t kMost = 250'000;
  if (numbers.size() > kMost) {
    return absl::InvalidArgumentError(
        file +
        ": has more numbers than the 250,000 of a request; put them into the mesh's file, "
        "as the property weight of PLY");
  }
  std::string values;
  values.reserve(numbers.size() * sizeof(float));
  for (const double number : numbers) AppendLittleEndian(static_cast<float>(number), &values);
  return values;
}

absl::Status SetWeights(const std::string& source, v1::CreateSceneRequest* request) {
  if (source.empty()) return absl::OkStatus();
  if (source == kWeightsOfMesh) {
    request->mutable_weights()->set_from_mesh(true);
    return absl::OkStatus();
  }
  LATTICED_ASSIGN_OR_RETURN(*request->mutable_weights()->mutable_values(), ReadWeights(source));
  return absl::OkStatus();
}

}  // namespace latticed::client
