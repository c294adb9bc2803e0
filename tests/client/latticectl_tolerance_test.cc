// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// --tolerance: what it takes, and that each command that has it keeps it.
#include "client/cpp/latticectl/command_line/tolerance_flag.h"

#include <gmock/gmock.h>

#include "core/mesh/mesh_io.h"
#include "tests/client/latticectl_server_fixture.h"

namespace latticed::client {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kVaseDiagonal = 5;  // roughly

absl::StatusOr<double> NoDiagonal() { return absl::InternalError("nobody needs it"); }

TEST(ToleranceFlag, TakesWorldUnitsLengthsAndPartsOfTheDiagonal) {
  struct Row {
    const char* text;
    double number;
    Tolerance::Unit unit;
  };
  for (const Row& row : {Row{"0.02", 0.02, Tolerance::Unit::kWorld},
                         {"1e-3", 1e-3, Tolerance::Unit::kWorld},
                         {"0.1mm", 1e-4, Tolerance::Unit::kMetres},
                         {"50um", 5e-5, Tolerance::Unit::kMetres},
                         {"2cm", 0.02, Tolerance::Unit::kMetres},
                         {"1in", 0.0254, Tolerance::Unit::kMetres},
                         {"0.5m", 0.5, Tolerance::Unit::kMetres},
                         {"1e-4D", 1e-4, Tolerance::Unit::kDiagonal}}) {
    const auto tolerance = ParseTolerance(row.text);
    ASSERT_TRUE(tolerance.has_value()) << row.text;
    EXPECT_DOUBLE_EQ(tolerance->number, row.number) << row.text;
    EXPECT_EQ(tolerance->unit, row.unit) << row.text;
  }
  for (const char* text :
       {"", "0", "-1", "mm", "D", "1e-4d", "0.1 mm", "1ft", "inf", "nan", "1e999"}) {
    EXPECT_FALSE(ParseTolerance(text).has_value()) << text;
  }
}

TEST(ToleranceFlag, BecomesWorldUnits) {
  EXPECT_EQ(*InWorldUnits(*ParseTolerance("0.02"), 0, NoDiagonal), 0.02);
  EXPECT_DOUBLE_EQ(*InWorldUnits(*ParseTolerance("0.1mm"), 0.001, NoDiagonal), 0.1);
  EXPECT_DOUBLE_EQ(
      *InWorldUnits(*ParseTolerance("1e-3D"), 0, [] { return absl::StatusOr<double>(40); }), 0.04);
  const auto unknown = InWorldUnits(*ParseTolerance("0.1mm"), 0, NoDiagonal);
  EXPECT_THAT(unknown.status().message(), HasSubstr("the scene's unit is unknown"));
}

TEST(ToleranceFlag, SaysWhatIsNotKept) {
  EXPECT_EQ(DescribeCertificate(0, 0), "");
  EXPECT_EQ(DescribeCertificate(0.5, 0.25), "; within 0.25 of the exact surface");
  EXPECT_THAT(DescribeCertificate(0.5, 0.75),
              HasSubstr("within 0.75 of the exact surface, not 0.5: more --segments"));
  EXPECT_THAT(DescribeCertificate(0.5, 0.75, /*own_points=*/true),
              HasSubstr("not 0.5: an edge has at most 32 segments"));
}

class LatticectlTolerance : public LatticectlServer {
 protected:
  void SetUp() override {
    LatticectlServer::SetUp();
    Run({"scene", "create", Path("vase.obj"), "--id", "scene-one", "--meters-per-unit", "0.01"});
    Run({"edit", "move", "scene-one", "--point", "1,1,2", "--by", "0.3,0.2,0.1"});
  }
  size_t Faces(const std::string& name) const {
    const auto file = ReadMeshFile(Path(name));
    EXPECT_OK(file);
    const auto mesh = ParseMesh(*file);
    EXPECT_OK(mesh);
    return mesh->face_count();
  }
};

TEST_F(LatticectlTolerance, ExportsByIt) {
  for (const char* tolerance : {"0.02", "0.2mm", "5e-3D"}) {
    SCOPED_TRACE(tolerance);
    const auto json =
        RunJson({"export", "scene-one", "-o", Path("o.ply"), "--tolerance", tolerance});
    EXPECT_GT(json.at("certifiedError"), 0);
    EXPECT_LE(json.at("certifiedError"), 5e-3 * 2 * kVaseDiagonal);
    EXPECT_GT(Faces("o.ply"), 0u);
  }
  Run({"export", "scene-one", "-o", Path("coarse.ply"), "--tolerance", "0.05"});
  Run({"export", "scene-one", "-o", Path("fine.ply"), "--tolerance", "0.0005"});
  EXPECT_GT(Faces("fine.ply"), Faces("coarse.ply"));
  EXPECT_THAT(Run({"export", "scene-one", "-o", Path("o.stl"), "--tolerance", "0.02"}),
              HasSubstr("of the exact surface"));
}

TEST_F(LatticectlTolerance, LengthsNeedAUnitOfTheScene) {
  Run({"scene", "create", Path("vase.obj"), "--id", "scene-two"});
  ExpectFailure({"export", "scene-two", "-o", Path("o.ply"), "--tolerance", "0.1mm"},
                HasSubstr("the scene's unit is unknown"));
  ExpectFailure({"export", "scene-two", "-o", Path("o.ply"), "--tolerance", "1e-12"},
                AllOf(HasSubstr("--tolerance"), HasSubstr("float32 positions allow")));
}

TEST_F(LatticectlTolerance, WatchesByIt) {
  const auto json = RunJson(
      {"watch", "scene-one", "--updates", "1", "--tolerance", "0.02", "--encoding", "quantised"});
  EXPECT_GT(json.at("certifiedError"), 0);
  EXPECT_LE(json.at("certifiedError"), 0.02);
  EXPECT_GT(json.at("points"), 0);
}

TEST_F(LatticectlTolerance, ApplyAndQuickstartTakeIt) {
  MustRun({"lattice", Path("vase.obj"), "--twist", "60", "-o", Path("L.json")});
  const auto applied = RunJson({"apply", Path("vase.obj"), "--lattice", Path("L.json"), "-o",
                                Path("o.ply"), "--tolerance", "0.02"});
  EXPECT_GT(applied.at("certifiedError"), 0);
  EXPECT_LE(applied.at("certifiedError"), 0.02);
  EXPECT_EQ(Faces("o.ply"), applied.at("triangles"));
  const auto quick = RunJson({"quickstart", "--output", Path("demo"), "--sample", "vase", "--steps",
                              "2", "--tolerance", "1e-3D"});
  EXPECT_GT(quick.at("certifiedError"), 0);
}

TEST_F(LatticectlTolerance, DecidesOnThePointsOfPatches) {
  MustRun({"lattice", Path("vase.obj"), "--twist", "60", "-o", Path("L.json")});
  const auto apply = [this](std::vector<std::string> more) {
    std::vector<std::string> arguments{"apply", Path("vase.obj"), "--lattice",  Path("L.json"),
                                       "-o",    Path("p.ply"),    "--encoding", "patches"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  };
  const auto coarse = RunJson(apply({"--tolerance", "0.02"}));
  const auto fine = RunJson(apply({"--tolerance", "5e-5D"}));

  EXPECT_GT(coarse.at("certifiedError"), 0.002);
  EXPECT_LE(coarse.at("certifiedError"), 0.02);
  EXPECT_LE(fine.at("certifiedError"), 5e-5 * 2 * kVaseDiagonal);
  EXPECT_GT(fine.at("points"), coarse.at("points"));
  EXPECT_EQ(fine.at("streamedBytes"), coarse.at("streamedBytes"));
  EXPECT_EQ(Faces("p.ply"), fine.at("triangles"));
  ExpectFailure(apply({}), AllOf(HasSubstr("--tolerance"), HasSubstr("is needed")));
  ExpectFailure(apply({"--tolerance", "1e-9"}),
                AllOf(HasSubstr("--tolerance"), HasSubstr("points of patches allow more than")));
}

TEST_F(LatticectlTolerance, WatchesPatchesByIt) {
  const auto watch = [this](std::vector<std::string> more) {
    std::vector<std::string> arguments{"watch", "scene-one",  "--updates",
                                       "1",     "--encoding", "patches"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunJson(arguments);
  };
  const auto coarse = watch({"--tolerance", "0.02"}), fine = watch({"--tolerance", "0.001"});
  const auto none = watch({});

  EXPECT_GT(coarse.at("certifiedError"), 0);
  EXPECT_LE(coarse.at("certifiedError"), 0.02);
  EXPECT_LE(fine.at("certifiedError"), 0.001);
  EXPECT_GT(fine.at("points"), coarse.at("points"));
  EXPECT_EQ(none.at("points"), 0) << "only bytes are told";
  EXPECT_EQ(none.at("bytes"), fine.at("bytes"));
  EXPECT_GT(none.at("bytes"), 0);
}

TEST_F(LatticectlTolerance, ADefaultViewHasIt) {
  Run({"scene", "create", Path("vase.obj"), "--id", "scene-three", "--tolerance", "0.2mm",
       "--meters-per-unit", "0.01"});
  EXPECT_THAT(Run({"scene", "show", "scene-three"}),
              AllOf(HasSubstr("tolerance 0.02, at most 10 segments"), HasSubstr("chosen/8 bits")));
  EXPECT_LE(RunJson({"watch", "scene-three", "--updates", "1"}).at("certifiedError"), 0.02);
}

}  // namespace
}  // namespace latticed::client
