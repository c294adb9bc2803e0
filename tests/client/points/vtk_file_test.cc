// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Points of VTK files: read in every coding, replaced, and all else left as it is.
#include "client/cpp/latticectl/vtk/vtk_file.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <bit>
#include <cstdint>

#include "absl/strings/escaping.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/string_view.h"
#include "fmt/format.h"
#include "tests/support/status_matchers.h"

namespace latticed::client {
namespace {

using ::testing::HasSubstr;

const std::vector<Vec3d> kRest{{0, 0, 0}, {1, 0.5, -2}};
const std::vector<Vec3d> kMoved{{1, 0, 0.5}, {2, 0.5, -1.5}};

// The file with kMoved in place of kRest, which it must have.
std::string Moved(const std::string& bytes, bool is_xml) {
  const auto file = VtkFile::Parse(bytes, is_xml);
  EXPECT_OK(file);
  if (!file.ok()) return "";
  EXPECT_EQ(file->points(), kRest);
  return file->WithPoints(kMoved);
}

void ExpectError(const std::string& bytes, bool is_xml, const std::string& why) {
  EXPECT_THAT(VtkFile::Parse(bytes, is_xml).status(),
              ::latticed::testing::StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr(why)));
}

constexpr char kText[] =
    "# vtk DataFile Version 3.0\na title\nASCII\nDATASET UNSTRUCTURED_GRID\n"
    "FIELD FieldData 1\nTIME 1 1 double\n0.25\n"
    "POINTS 2 float\n0 0\n0 1 5e-1 -2\nCELLS 1 3\n2 0 1\nCELL_TYPES 1\n3\n"
    "POINT_DATA 2\nSCALARS p float 1\nLOOKUP_TABLE default\n7\n8\n";

TEST(LegacyVtk, ReplacesThePointsOfText) {
  EXPECT_EQ(Moved(kText, false),
            "# vtk DataFile Version 3.0\na title\nASCII\nDATASET UNSTRUCTURED_GRID\n"
            "FIELD FieldData 1\nTIME 1 1 double\n0.25\n"
            "POINTS 2 double\n1 0 0.5\n2 0.5 -1.5\n\nCELLS 1 3\n2 0 1\nCELL_TYPES 1\n3\n"
            "POINT_DATA 2\nVECTORS displacement double\n1 0 0.5\n1 0 0.5\n\n"
            "SCALARS p float 1\nLOOKUP_TABLE default\n7\n8\n");
}

TEST(LegacyVtk, MakesPointDataWhereThereAreNone) {
  std::string bytes(kText);
  bytes.erase(bytes.find("POINT_DATA"));
  EXPECT_THAT(Moved(bytes, false),
              ::testing::EndsWith("CELL_TYPES 1\n3\n\nPOINT_DATA 2\nVECTORS displacement "
                                  "double\n1 0 0.5\n1 0 0.5\n\n"));
}

// Big-endian.
template <typename T>
std::string Bytes(const std::vector<T>& numbers) {
  std::string bytes;
  for (const T number : numbers) {
    char one[sizeof(T)];
    std::copy_n(reinterpret_cast<const char*>(&number), sizeof(T), one);
    std::reverse(one, one + sizeof(T));
    bytes.append(one, sizeof(T));
  }
  return bytes;
}

TEST(LegacyVtk, ReplacesThePointsOfBytes) {
  const std::string head =
      "# vtk DataFile Version 5.1\n\nBINARY\nDATASET POLYDATA\nFIELD FieldData 1\nN 2 1 int\n" +
      Bytes<int32_t>({10, 32}) + "\n";
  const std::string tail = "\nMETADATA\nINFORMATION 0\n\nLINES 2 2\nOFFSETS vtktypeint64\n" +
                           Bytes<int64_t>({0, 2}) + "\nCONNECTIVITY vtktypeint64\n" +
                           Bytes<int64_t>({0, 1}) + "\nPOINT_DATA 2\n";
  const std::string data = Bytes<double>({1, 0, 0.5, 2, 0.5, -1.5});
  const std::string moves = Bytes<double>({1, 0, 0.5, 1, 0, 0.5});
  const std::string expected =
      head + "POINTS 2 double\n" + data + tail + "VECTORS displacement double\n" + moves + "\n";
  EXPECT_EQ(Moved(head + "POINTS 2 float\n" + Bytes<float>({0, 0, 0, 1, 0.5F, -2}) + tail, false),
            expected);
  EXPECT_EQ(Moved(head + "POINTS 2 double\n" + Bytes<double>({0, 0, 0, 1, 0.5, -2}) + tail, false),
            expected);
}

TEST(LegacyVtk, SaysWhatIsWrong) {
  const auto expect = [](const std::string& from, const std::string& to, const std::string& why) {
    ExpectError(absl::StrReplaceAll(kText, {{from, to}}), false, why);
  };
  ExpectError("", false, "does not begin with '# vtk'");
  ExpectError("<VTKFile>", false, "does not begin with '# vtk'");
  expect("ASCII", "TEXT", "neither ASCII nor BINARY");
  expect("UNSTRUCTURED_GRID", "RECTILINEAR_GRID", "no data set with points");
  expect("POINTS 2 float", "POINTS 2 int", "of type int");
  expect("POINTS 2 float", "POINTS x float", "no number and type");
  expect("POINTS", "VERTICES", "has VERTICES before its POINTS");
  expect("5e-1", "half", "has 'half' in place of a number");
  expect("TIME 1 1", "TIME 1", "arrays cannot be read");
  expect("SCALARS p float 1\nLOOKUP_TABLE default", "VECTORS displacement double",
         "already has point data named displacement");
  expect("POINTS 2", "POINTS 3", "has 'CELLS' in place of a number");
  std::string bytes = absl::StrReplaceAll(kText, {{"ASCII", "BINARY"}, {"FieldData 1", "F 0"}});
  bytes = absl::StrReplaceAll(bytes, {{"TIME 1 1 double\n0.25\n", ""}, {"POINTS 2", "POINTS 999"}});
  ExpectError(bytes, false, "of 2997 numbers");
  ExpectError(absl::StrReplaceAll(bytes, {{"POINTS 999", "POINTS 4294967295"}}), false,
              "of 12884901885 numbers");
  bytes.erase(bytes.find("FIELD"));
  ExpectError(bytes, false, "has no POINTS");
}

constexpr char kXml[] =
    "<?xml version=\"1.0\"?>\n<!-- <Points> -->\n<VTKFile type=\"UnstructuredGrid\" "
    "byte_order=\"LittleEndian\"{}>\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"2\" "
    "NumberOfCells='1'>\n{}<Points>\n<DataArray type=\"Float32\" Name=\"p\" "
    "NumberOfComponents=\"3\" {}\n</Points>\n<Cells>…</Cells>\n</Piece>\n</UnstructuredGrid>\n{}"
    "</VTKFile>\n";
constexpr char kMoves[] =
    "<DataArray type=\"Float64\" Name=\"displacement\" NumberOfComponents=\"3\" "
    "format=\"ascii\">\n1 0 0.5\n1 0 0.5\n</DataArray>";
constexpr char kPlain[] = "GAAAAAAAAAAAAAAAAAAAAAAAgD8AAAA/AAAAwA==";  // 24 bytes, 6 floats
// Two blocks, of 16 and 8 bytes.
constexpr char kDeflated[] = "AgAAABAAAAAIAAAADQAAABAAAAA=eJxjYEAGDfYAAU8AwHicY2BgsGdgYDgAAAIDAQA=";

std::string Xml(const std::string& file, const std::string& array, const std::string& appended = "",
                const std::string& data = "") {
  return fmt::format(kXml, file, data, array, appended);
}

std::string Binary(const std::string& text) {
  return fmt::format("format=\"binary\">\n  {}\n</DataArray>", text);
}

TEST(XmlVtk, ReplacesPointsInEveryCoding) {
  std::string plain, deflated;
  ASSERT_TRUE(absl::Base64Unescape(kPlain, &plain));
  const absl::string_view counts(kDeflated, 28);
  std::string blocks;
  ASSERT_TRUE(absl::Base64Unescape(counts, &deflated));
  ASSERT_TRUE(absl::Base64Unescape(&kDeflated[28], &blocks));
  deflated += blocks;
  const std::string zlib = " compressor=\"vtkZLibDataCompressor\"";
  const std::string offset = "format=\"appended\" offset=\"3\"/>";
  const auto appended = [](const char* encoding, const std::string& data) {
    return fmt::format("<AppendedData encoding=\"{}\">\n _<<\"{}</AppendedData>\n", encoding, data);
  };
  std::string wide = plain;
  wide.insert(4, 4, '\0');
  struct Row {
    std::string file, array, appended;
  };
  for (const Row& row : {Row{"", "format='ascii'>0 0 0\n1 0.5 -2.0</DataArray>", ""},
                         {"", "format='ascii'>0 0 0 1 .5 -2<K>0 1</K></DataArray>", ""},
                         {"", Binary(kPlain), ""},
                         {zlib, Binary(kDeflated), ""},
                         {" header_type=\"UInt64\"", Binary(absl::Base64Escape(wide)), ""},
                         {"", offset, appended("raw", plain)},
                         {zlib, offset, appended("raw", deflated)},
                         {"", offset, appended("base64", kPlain)},
                         {zlib, offset, appended("base64", kDeflated)}}) {
    SCOPED_TRACE(row.file + row.array + row.appended);
    const std::string rest = row.appended.empty()
                                 ? ""
                                 : "<DataArray type=\"Float32\" Name=\"rest\" "
                                   "NumberOfComponents=\"3\" format=\"appended\" offset=\"3\"/>";
    std::string expected =
        Xml(row.file, "format=\"ascii\">\n1 0 0.5\n2 0.5 -1.5\n</DataArray>", row.appended,
            fmt::format("<PointData>{}{}</PointData>\n", kMoves, rest));
    expected =
        absl::StrReplaceAll(expected, {{"\"Float32\" Name=\"p\"", "\"Float64\" Name=\"Points\""}});
    EXPECT_EQ(Moved(Xml(row.file, row.array, row.appended), true), expected);

    const std::string velocities =
        absl::StrReplaceAll(kMoves, {{"\"displacement\"", "\"lattice_velocity\""}});
    const auto file = VtkFile::Parse(Xml(row.file, row.array, row.appended), true);
    ASSERT_OK(file);
    EXPECT_EQ(
        file->WithVectors("lattice_velocity", std::vector<Vec3d>(2, {1, 0, 0.5})).value_or(""),
        Xml(row.file, row.array, row.appended,
            fmt::format("<PointData>{}</PointData>\n", velocities)));
  }
}

TEST(XmlVtk, ReadsBigEndianNumbers) {
  const std::string data = Bytes<uint32_t>({24}) + Bytes<float>({0, 0, 0, 1, 0.5F, -2});
  const std::string bytes = absl::StrReplaceAll(Xml("", Binary(absl::Base64Escape(data))),
                                                {{"LittleEndian", "BigEndian"}});
  EXPECT_THAT(Moved(bytes, true), HasSubstr(kMoves));
}

TEST(XmlVtk, AddsToThePointDataThatAreThere) {
  const std::string array = "format='ascii'>0 0 0 1 .5 -2</DataArray>";
  EXPECT_THAT(Moved(Xml("", array, "", "<PointData Scalars=\"s\"/>\n"), true),
              HasSubstr(fmt::format("<PointData Scalars=\"s\">{}</PointData>\n<Points>", kMoves)));
  const std::string data = "<PointData Scalars=\"s\"><DataArray Name=\"s\"/></PointData>\n";
  EXPECT_THAT(Moved(Xml("", array, "", data), true),
              HasSubstr(fmt::format("<PointData Scalars=\"s\">{}<DataArray Name=\"s\"/>", kMoves)));
}

TEST(XmlVtk, ReadsSeveralPieces) {
  const std::string piece =
      "<Piece NumberOfPoints=\"1\"><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" "
      "format=\"ascii\">{}</DataArray></Points></Piece>";
  const std::string bytes = fmt::format("<VTKFile type=\"PolyData\">{}{}</VTKFile>",
                                        absl::StrReplaceAll(piece, {{"{}", "0 0 0"}}),
                                        absl::StrReplaceAll(piece, {{"{}", "1 0.5 -2"}}));
  const std::string moved = Moved(bytes, true);
  EXPECT_LT(moved.find("\n1 0 0.5\n</DataArray></Points>"),
            moved.find("\n2 0.5 -1.5\n</DataArray></Points>"));
  EXPECT_THAT(moved, HasSubstr("\n2 0.5 -1.5\n</DataArray></Points></Piece></VTKFile>"));
}

TEST(XmlVtk, SaysWhatIsWrong) {
  const std::string good = Xml("", Binary(kPlain));
  const auto expect = [&](const std::string& from, const std::string& to, const std::string& why) {
    ExpectError(absl::StrReplaceAll(good, {{from, to}}), true, why);
  };
  ExpectError(kText, true, "does not begin with VTKFile");
  ExpectError("<VTKFile type=\"ImageData\"/>", true, "is of type 'ImageData'");
  ExpectError("<VTKFile type=\"PolyData\"/>", true, "has no Piece with Points");
  ExpectError("<VTKFile type=\"PolyData\"", true, "an XML tag that does not end");
  ExpectError("<VTKFile type=\"PolyData\"><Piece></Piece>", true, "a Piece without Points");
  ExpectError("<VTKFile type=\"PolyData\"><Piece><Points/></Piece>", true, "without a DataArray");
  ExpectError(Xml(" compressor=\"vtkLZ4DataCompressor\"", ""), true, "vtkLZ4DataCompressor");
  expect("Float32", "Int32", "of type Int32");
  expect("</DataArray>", "", "a DataArray that does not end");
  expect("NumberOfPoints=\"2\"", "NumberOfPoints=\"3\"", "has 2 points in a Piece of '3'");
  expect("Components=\"3\"", "Components=\"2\"", "not three coordinates");
  expect("binary", "text", "have no format");
  expect(kPlain, "GAAAAAAA", "damaged or cut off");
  expect(kPlain, "%%%%%%%%", "damaged or cut off");
  const std::string zlib = " compressor='vtkZLibDataCompressor'";
  std::string damaged(kDeflated);
  damaged[40] = damaged[40] == 'A' ? 'B' : 'A';
  ExpectError(Xml(zlib, Binary(damaged)), true, "damaged or cut off");
  ExpectError(Xml(zlib, Binary(kPlain)), true, "damaged or cut off");
  ExpectError(Xml("", "format=\"appended\" offset=\"0\"/>"), true, "lacks the appended data");
  ExpectError(Xml("", "format=\"appended\" offset=\"99\"/>", "<AppendedData encoding='raw'>_"),
              true, "lacks the appended data");
  ExpectError(Xml("", "format=\"binary\">\n</DataArray>", "",
                  "<PointData><DataArray Name='displacement'/></PointData>"),
              true, "damaged");
  ExpectError(
      Xml("", Binary(kPlain), "", "<PointData><DataArray Name='displacement'/></PointData>"), true,
      "already has point data named displacement");
}

}  // namespace
}  // namespace latticed::client
