// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/bezier_net.h"

#include <algorithm>

#include "core/ffd/stage_matrices.h"

namespace latticed::bench {

NetTables MakeNetTables(int degree) {
  NetTables tables{.degree = degree, .m = BernsteinCount(degree), .j = {}, .k = {}, .inverse = {}};
  const std::vector<double> inverse = InverseBernsteinMatrix(degree);
  std::copy(inverse.begin(), inverse.end(), tables.inverse);
  for (int i = degree; i >= 0; --i) {
    for (int k = 0; k <= degree - i; ++k) {
      const int at = BernsteinIndex(degree, i, k);
      tables.j[at] = static_cast<uint8_t>(degree - i - k);
      tables.k[at] = static_cast<uint8_t>(k);
    }
  }
  return tables;
}

}  // namespace latticed::bench
