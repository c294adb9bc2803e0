// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// latticectl points, and by it the calls of the C++ client: CSV and NPY files in and out.
#include <cmath>
#include <cstdint>

#include "absl/strings/str_replace.h"
#include "client/cpp/latticectl/geometry/point_table.h"
#include "client/cpp/latticectl/vtk/vtk_file.h"
#include "core/base/read_file.h"
#include "core/mesh/little_endian.h"
#include "fmt/format.h"
#include "tests/client/latticectl_server_fixture.h"

namespace latticed::client {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class LatticectlPoints : public LatticectlServer {
 protected:
  void SetUp() override {
    LatticectlServer::SetUp();
    Run({"scene", "create", Path("vase.obj"), "--id", "vase"});
  }
  std::string Write(const std::string& name, const std::string& bytes) const {
    EXPECT_OK(WriteFile(Path(name), bytes));
    return Path(name);
  }
  PointTable Read(const std::string& name) const {
    const auto table = ReadPointTable(Path(name));
    EXPECT_OK(table);
    return table.value_or(PointTable());
  }
  std::string Points(const std::string& name, size_t columns) const {
    PointTable table{.columns = columns};
    for (int i = 0; i < 40; ++i) {
      for (size_t c = 0; c < columns; ++c) table.numbers.push_back(std::sin(i + 7. * double(c)));
    }
    EXPECT_OK(WritePointTable(Path(name), table));
    return Path(name);
  }
};

TEST_F(LatticectlPoints, DeformsFilesOfPoints) {
  const std::string csv = Write("some.csv", "x, y, z\n0,0,1\r\n\n 0.25,-0.5,2e0\n100,0,0\n");
  EXPECT_EQ(Run({"points", "deform", "vase", csv, "-o", Path("rest.csv")}),
            Path("rest.csv") + ": 3 points, revision 0\n");
  const PointTable rest = Read("rest.csv");
  EXPECT_NEAR(rest.numbers[4], -0.5, 1e-14);

  Run({"edit", "move", "vase", "--point", "1,1,1", "--by", "0", "0", "0.5"});
  Run({"points", "deform", "vase", csv, "-o", Path("moved.npy")});
  const PointTable moved = Read("moved.npy");
  ASSERT_EQ(moved.rows(), 3u);
  EXPECT_GT(moved.numbers[2], 1.0001);
  EXPECT_EQ(moved.numbers[6], 100);
  EXPECT_EQ(RunJson({"points", "list", "vase"}).size(), 0u) << "the set is deleted";
}

TEST_F(LatticectlPoints, CarriesNormalsInSixColumns) {
  const std::string npy = Points("six.npy", 6);
  const nlohmann::json done = RunJson({"points", "deform", "vase", npy, "-o", Path("out.csv")});
  EXPECT_EQ(done["rows"], 40);
  EXPECT_EQ(done["columns"], 6);
  const PointTable out = Read("out.csv"), in = Read("six.npy");
  for (size_t row = 0; row < 40; ++row) {
    const double* normal = &out.numbers[6 * row + 3];
    EXPECT_NEAR(std::hypot(normal[0], normal[1], normal[2]), 1, 1e-12);
    EXPECT_NEAR(out.numbers[6 * row], in.numbers[6 * row], 1e-12);
  }
}

TEST_F(LatticectlPoints, VelocitiesAndGradientAreAdjoint) {
  const std::string points = Points("points.npy", 6);
  PointTable tangents{.columns = 3};
  for (int i = 0; i < 3 * 64; ++i) tangents.numbers.push_back(std::cos(3. * i));
  ASSERT_OK(WritePointTable(Path("tangents.csv"), tangents));

  Run({"points", "velocities", "vase", points, Path("tangents.csv"), "-o", Path("moved.npy")});
  EXPECT_EQ(Run({"points", "gradient", "vase", points, points, "-o", Path("gradient.npy")}),
            Path("gradient.npy") + ": 64 derivatives, revision 0\n");

  const PointTable moved = Read("moved.npy"), cotangents = Read("points.npy"),
                   gradient = Read("gradient.npy");
  double forward = 0, reverse = 0;
  for (size_t i = 0; i < moved.numbers.size(); ++i) {
    forward += moved.numbers[i] * cotangents.numbers[i];
  }
  ASSERT_EQ(gradient.numbers.size(), tangents.numbers.size());
  for (size_t i = 0; i < gradient.numbers.size(); ++i) {
    reverse += gradient.numbers[i] * tangents.numbers[i];
  }
  EXPECT_NEAR(forward, reverse, 1e-12);
  EXPECT_GT(std::abs(forward), 1e-3);
}

TEST_F(LatticectlPoints, DerivesByOneOfSeveralLattices) {
  MustRun({"lattice", Path("vase.obj"), "-o", Path("whole.json")});
  MustRun({"lattice", Path("vase.obj"), "--size", "3,4,5", "-o", Path("other.json")});
  Run({"scene", "create", Path("vase.obj"), "--id", "both", "--lattice", Path("whole.json"),
       "--lattice", Path("other.json")});
  const std::string points = Points("points.npy", 3);
  const auto gradient = [&](const std::string& number) {
    return std::vector<std::string>{
        "points",           "gradient", "both", points, points, "-o", Path("gradient.npy"),
        "--lattice-number", number};
  };
  EXPECT_THAT(Run(gradient("0")), HasSubstr(": 64 derivatives"));
  EXPECT_THAT(Run(gradient("1")), HasSubstr(": 60 derivatives"));
  ExpectFailure(gradient("2"), HasSubstr("lattice: got 2"));
  Run({"points", "velocities", "both", points, Path("gradient.npy"), "-o", Path("moved.npy"),
       "--lattice-number", "1"});
  EXPECT_EQ(Read("moved.npy").rows(), 40u);
}

// Two points, of which the scene moves the first.
constexpr char kGrid[] =
    "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 2 double\n"
    "0.25 -0.5 0\n100 0 0\nCELLS 1 3\n2 0 1\nCELL_TYPES 1\n3\n";
constexpr char kXmlGrid[] =
    "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"2\">"
    "<Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">"
    "0.25 -0.5 0 100 0 0</DataArray></Points><Cells/></Piece></UnstructuredGrid></VTKFile>";

TEST_F(LatticectlPoints, DeformsVtkFilesAndKeepsTheirCells) {
  Run({"edit", "move", "vase", "--point", "1,1,1", "--by", "0", "0", "0.5"});
  const auto first = [](const std::string& bytes, bool is_xml) {
    const auto file = VtkFile::Parse(bytes, is_xml);
    EXPECT_OK(file);
    return file.ok() && file->points().size() == 2 ? file->points()[0] : Vec3d{};
  };
  Run({"points", "deform", "vase", Write("in.vtk", kGrid), "-o", Path("out.vtk")});
  const std::string grid = ReadFile(Path("out.vtk")).value_or("");
  EXPECT_THAT(grid, AllOf(HasSubstr("\n100 0 0\n\nCELLS 1 3\n2 0 1\nCELL_TYPES 1\n3\n"),
                          HasSubstr("POINT_DATA 2\nVECTORS displacement double\n"),
                          ::testing::EndsWith("\n0 0 0\n\n")));
  Run({"points", "deform", "vase", Write("in.vtu", kXmlGrid), "-o", Path("out.vtu")});
  const std::string xml = ReadFile(Path("out.vtu")).value_or("");
  EXPECT_THAT(xml, HasSubstr("</Points><Cells/></Piece>"));
  Run({"points", "deform", "vase", Path("in.vtu"), "-o", Path("out.csv")});
  const PointTable table = Read("out.csv");
  ASSERT_EQ(table.rows(), 2u);
  EXPECT_GT(table.numbers[2], 0.01);
  EXPECT_EQ(table.numbers[3], 100);

  // A file that was deformed is no file at rest, and a table has no cells.
  ExpectFailure({"points", "deform", "vase", Path("out.vtu"), "-o", Path("a.vtu")},
                HasSubstr("out.vtu already has point data named displacement"));
  ExpectFailure({"points", "deform", "vase", Path("out.vtk"), "-o", Path("a.vtk")},
                HasSubstr("out.vtk already has point data named displacement"));
  ExpectFailure({"points", "deform", "vase", Path("out.csv"), "-o", Path("a.vtu")},
                HasSubstr("a.vtu: a .vtu file is written from one"));
  ExpectFailure({"points", "deform", "vase", Path("in.vtu"), "-o", Path("a.vtk")},
                HasSubstr("a.vtk: a .vtk file is written from one"));
  EXPECT_FALSE(ReadFile(Path("a.vtk")).ok());
  const std::string none =
      Write("none.vtk", "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 0 float\n");
  ExpectFailure({"points", "deform", "vase", none, "-o", Path("a.vtk")},
                HasSubstr("none.vtk has no points"));
  EXPECT_EQ(first(absl::StrReplaceAll(grid, {{"displacement", "moved"}}), false),
            first(absl::StrReplaceAll(xml, {{"displacement", "moved"}}), true));
}

TEST_F(LatticectlPoints, WritesVelocitiesIntoVtkFiles) {
  PointTable tangents{.columns = 3};
  for (int i = 0; i < 3 * 64; ++i) tangents.numbers.push_back(std::cos(3. * i));
  ASSERT_OK(WritePointTable(Path("tangents.csv"), tangents));
  const auto velocities = [&](const std::string& from, const std::string& to) {
    return std::vector<std::string>{"points", "velocities", "vase", from, Path("tangents.csv"),
                                    "-o",     Path(to)};
  };
  const std::string grid = Write("in.vtk", kGrid), xml = Write("in.vtu", kXmlGrid);
  Run(velocities(grid, "v.csv"));
  const PointTable table = Read("v.csv");
  ASSERT_EQ(table.rows(), 2u);
  const std::string first =
      fmt::format("\n{} {} {}\n0 0 0\n", table.numbers[0], table.numbers[1], table.numbers[2]);
  Run(velocities(grid, "v.vtk"));
  EXPECT_EQ(*ReadFile(Path("v.vtk")),
            kGrid + ("\nPOINT_DATA 2\nVECTORS lattice_velocity double" + first) + "\n");
  Run(velocities(xml, "v.vtu"));
  const std::string written = *ReadFile(Path("v.vtu"));
  EXPECT_THAT(written, AllOf(HasSubstr("Name=\"lattice_velocity\""), HasSubstr(first),
                             HasSubstr("0.25 -0.5 0 100 0 0</DataArray></Points><Cells/>")));

  ExpectFailure(velocities(Path("v.vtu"), "again.vtu"),
                HasSubstr("v.vtu already has point data named lattice_velocity"));
  ExpectFailure(velocities(Path("v.csv"), "again.vtu"),
                HasSubstr("again.vtu: a .vtu file is written from one"));
  EXPECT_THAT(MustRun({"points", "velocities", "--help"}), HasSubstr(".vtu, .vtp or .vts"));
}

TEST_F(LatticectlPoints, SaysWhatIsWrong) {
  const std::string points = Points("points.csv", 3), out = Path("out.csv");
  const auto expect = [&](const std::string& bytes, const std::string& name, const char* why) {
    ExpectFailure({"points", "deform", "vase", Write(name, bytes), "-o", out}, HasSubstr(why));
  };
  expect("", "a.csv", "a.csv: has no points");
  expect("1,2,3\n1,2\n", "b.csv", "b.csv: line 2: got 2 numbers, the lines before have 3");
  expect("1,2,3\n1,b,3\n", "c.csv", "c.csv: line 2: '1,b,3' are no numbers separated by commas");
  expect("1,2\n", "d.csv", "has 2 columns; 3, or 6 with normals, are needed");
  expect("1,2,nan\n", "e.csv", "positions[0]");
  expect("no numpy", "f.npy", "f.npy: is no .npy file");
  ExpectFailure({"points", "deform", "vase", Path("none.csv"), "-o", out}, HasSubstr("none.csv"));
  ExpectFailure({"points", "deform", "nobody", points, "-o", out}, HasSubstr("nobody"));
  ExpectFailure({"points", "gradient", "vase", points, Points("six.csv", 6), "-o", out},
                HasSubstr("the point set has no normals"));
  ExpectFailure({"points", "velocities", "vase", points, points, "-o", out},
                HasSubstr("points.csv: has 40 rows, 64 control points are in lattice 0"));
  ExpectFailure({"points", "velocities", "vase", points, Path("six.csv"), "-o", out},
                HasSubstr("six.csv: has 6 columns, a velocity has 3"));
  ExpectFailure({"points", "gradient", "vase", points, Write("short.csv", "1,2,3\n"), "-o", out},
                HasSubstr("short.csv: has 1 rows, 40 points are in " + points));
  ExpectFailure({"points", "delete", "vase", "no-such-set"}, HasSubstr("no-such-set"));
  EXPECT_EQ(Latticectl(AtServer({"points", "deform", "vase", "points.vtx", "-o", out})).code, 2);
  EXPECT_EQ(RunJson({"points", "list", "vase"}).size(), 0u) << "also after an error";
}

// As numpy.save writes an array.
std::string Npy(const std::string& header, const std::string& data) {
  std::string bytes = "\x93NUMPY\x01";
  bytes += '\0';
  AppendLittleEndian(static_cast<uint16_t>(header.size()), &bytes);
  return bytes + header + data;
}

TEST_F(LatticectlPoints, ReadsWhatNumPyWritesAndNothingElse) {
  std::string floats, doubles;
  for (const float x : {1.F, 2.5F, -3.F}) {
    AppendLittleEndian(x, &floats);
    AppendLittleEndian(double{x}, &doubles);
  }
  const std::string f8 = "{'descr': '<f8', 'fortran_order': False, 'shape': (1, 3), }\n";
  const std::string f4 = "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 3), }\n";
  Write("f8.npy", Npy(f8, doubles));
  Write("f4.npy", Npy(f4, floats));
  EXPECT_EQ(Read("f8.npy").numbers, (std::vector<double>{1, 2.5, -3}));
  EXPECT_EQ(Read("f4.npy").numbers, (std::vector<double>{1, 2.5, -3}));

  for (const auto& [bytes, why] : std::vector<std::pair<std::string, std::string>>{
           {Npy("{'descr': '>f8', 'fortran_order': False, 'shape': (1, 3)}", doubles), "'>f8'"},
           {Npy("{'descr': '<f8', 'fortran_order': True, 'shape': (1, 3)}", doubles), "C order"},
           {Npy("{'descr': '<f8', 'fortran_order': False, 'shape': (3,)}", doubles), "1 columns"},
           {Npy("{'descr': '<f8', 'fortran_order': False, 'shape': (1, 1, 3)}", doubles),
            "dimensions"},
           {Npy("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3)}", doubles), "2 rows"},
           {Npy("{'descr': '<f8', 'fortran_order': False, 'shape': (1, 0)}", doubles),
            "dimensions"},
           {Npy("{'descr': '<f8', 'fortran_order': False, 'shape': (-1, 3)}", doubles),
            "dimensions"},
           {Npy("{}", doubles), "the type ''"},
           {Npy(f8, doubles).substr(0, 20), "ends in its header"}}) {
    const auto table = ReadPointTable(Write("bad.npy", bytes));
    EXPECT_THAT(table.status().ToString(), AllOf(HasSubstr("bad.npy"), HasSubstr(why)));
  }
}

}  // namespace
}  // namespace latticed::client
