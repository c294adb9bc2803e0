// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Mesh files of VTK whose points are replaced. Everything else in the file, cells, data and text, stays byte for byte.
//
//   .vtk              legacy, versions 1 to 5, ASCII or binary: unstructured grids, polydata, structured grids
//   .vtu, .vtp, .vts  XML with the same kinds; arrays inline or appended, raw or Base64, plain or compressed by zlib
//
// Points are read as float or double and written as double; in XML inline as text, which any byte order, header and
// compressor of the file allows. Their moves from where they were are written as point data "displacement",
// in XML files with appended points also where they were, as "rest". Or points stay, and vectors at them are written as point
// data of another name.
//
// Why no library: VTK's own is 100 MB. XML parsers refuse appended raw arrays, which VTK writes unless told otherwise, and
// would write again what only has to be passed on.
//
// Errors   kInvalidArgument in one sentence, without the file's name
// Threads  immutable
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_VTK_VTK_FILE_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_VTK_VTK_FILE_H_

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/vec.h"

namespace latticed::client {

// A place in a file, and what stands there in place of the bytes from begin to end.
struct VtkSplice {
  enum class What { kPoints, kMoves };
  size_t begin = 0, end = 0;
  std::string before, after;  // around the numbers
  std::string rest,
      closing;  // then follow: the points at rest, if they are replaced; what ends the point data
  What what = What::kPoints;
  size_t first_point = 0, points = 0;
};

class VtkFile {
 public:
  // `is_xml`: of which kind the bytes are said to be.
  [[nodiscard]] static absl::StatusOr<VtkFile> Parse(std::string bytes, bool is_xml);

  const std::vector<Vec3d>& points() const { return points_; }
  // The file with as many points in place of these.
  [[nodiscard]] std::string WithPoints(std::span<const Vec3d> points) const;
  // The file with a vector for each point, as point data. kInvalidArgument where the file has the name already.
  [[nodiscard]] absl::StatusOr<std::string> WithVectors(std::string_view name,
                                                        std::span<const Vec3d> vectors) const;

 private:
  std::string bytes_;
  std::vector<Vec3d> points_;
  std::vector<VtkSplice> splices_;  // by begin
  bool is_text_ = true;             // else numbers are big-endian doubles
};

// Whether a path ends in .vtk, .vtu, .vtp or .vts.
[[nodiscard]] bool IsVtkFileName(const std::string& path);
// Whether it ends in one of the last three.
[[nodiscard]] bool IsXmlVtkFileName(const std::string& path);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_VTK_VTK_FILE_H_
