// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A refusal of the server names the options of the command line, not the fields of the request.
#include <CLI/CLI.hpp>
#include <functional>

#include "absl/strings/str_split.h"
#include "client/cpp/latticectl/command_line/field_flags.h"
#include "client/cpp/latticectl/commands/bench_flags.h"
#include "client/cpp/latticectl/commands/commands.h"
#include "latticed/v1/edit.pb.h"
#include "latticed/v1/lattice.pb.h"
#include "latticed/v1/mesh.pb.h"
#include "latticed/v1/scene.pb.h"
#include "latticed/v1/surface.pb.h"
#include "tests/client/latticectl_server_fixture.h"

namespace latticed::client {
namespace {

using ::testing::StartsWith;

class LatticectlWords : public LatticectlServer {
 protected:
  void SetUp() override {
    LatticectlServer::SetUp();
    Run({"scene", "create", Path("vase.obj"), "--id", kScene});
  }

  // Writes a lattice with a change. Returns its path.
  std::string WriteLattice(const std::function<void(nlohmann::json&)>& change) const {
    auto lattice = nlohmann::json::parse(MustRun({"lattice", Path("vase.obj")}));
    change(lattice);
    EXPECT_OK(WriteFile(Path("changed.json"), lattice.dump()));
    return Path("changed.json");
  }
  // Expects that the server refuses the command with a message that begins with this.
  void ExpectWords(std::vector<std::string> arguments, const std::string& words) const {
    SCOPED_TRACE(::testing::PrintToString(arguments));
    ExpectFailure(std::move(arguments), StartsWith("latticectl: " + words));
  }

  static constexpr char kScene[] = "scene-of-words";
};

TEST_F(LatticectlWords, OfAFitAndASceneAreItsOptions) {
  const std::string vase = Path("vase.obj"), beam = Path("beam.obj");
  MustRun({"sample", "beam", "-o", beam});  // which the server does not have yet
  ExpectWords({"scene", "create", vase, "--degree", "2,5,2"},
              "--degree, v: got 5, allowed is 1 to 3 (OUT_OF_RANGE, request ");
  ExpectWords({"scene", "create", vase, "--size", "2,4,4"}, "--size, u: got 2, allowed is 3 to ");
  ExpectWords({"scene", "create", vase, "--size", "200,400,400"}, "--size: got 32000000, ");
  ExpectWords({"scene", "create", vase, "--padding", "-1"}, "--padding: got -1, ");
  ExpectWords({"scene", "create", vase, "--outside", "falloff:5000"},
              "--outside, widths[0]: got 5000, ");
  ExpectWords({"scene", "create", vase, "--outside", "linear"}, "--outside, widths: must be set ");
  ExpectWords({"scene", "create", vase, "--id", "X"}, "--id: must be 1 to 63 of ");
  ExpectWords({"scene", "list", "--filter", "="}, "--filter: '=' is neither ");
  ExpectWords({"meshes", "--filter", "A"}, "--filter: 'A' is neither ");
  ExpectWords({"upload", beam, "--label", "A=1"}, "--label: the key 'A' is not ");
  ExpectWords({"upload", beam, "--name", std::string(300, 'x')}, "--name: got 300, ");
  ExpectWords({"watch", kScene, "--max-points", "1"}, "--max-points: got 1, 1 segment ");
  ExpectWords({"export", kScene, "-o", Path("x.ply"), "--revision", "77"},
              "--revision: got 77, the scene is at 0; run the command again");
}

TEST_F(LatticectlWords, OfALatticesFileAreTheOptionAndItsKey) {
  const auto degree = WriteLattice([](auto& lattice) { lattice["degree"]["v"] = 0; });
  ExpectWords({"scene", "create", Path("vase.obj"), "--lattice", degree},
              "--lattice, degree.v: got 0, allowed is 1 to 3");
  const auto knots = WriteLattice([](auto& lattice) { lattice["knotsU"] = {0, 0, 0, 1}; });
  ExpectWords({"scene", "create", Path("vase.obj"), "--lattice", knots},
              "--lattice, knotsU: got 4 knots, ");
  const auto points = WriteLattice([](auto& lattice) { lattice["controlPoints"].erase(0); });
  ExpectWords({"apply", Path("vase.obj"), "--lattice", points, "-o", Path("o.ply")},
              "--lattice, controlPoints: got 191 numbers, ");
  const auto endless = WriteLattice([](auto& lattice) {
    lattice["outside"] = {{"mode", "OUTSIDE_MODE_LINEAR"}};
  });
  ExpectWords({"edit", "carry", kScene, "--lattice", endless},
              "--lattice, outside.widths: must be set for a linear one here");
}

TEST_F(LatticectlWords, OfAnEditAreItsOptions) {
  ExpectWords({"edit", "move", kScene, "--point", "1,1,1", "--by", "1e300,0,0"},
              "--by: got 1e+300, ");
  ExpectWords({"edit", "move", kScene, "--point", "1,1,1", "--point", "2,2,2", "--point", "1,1,1",
               "--by", "1,0,0"},
              "--point, number 3: control point 21 is named twice");
  ExpectWords({"edit", "move", kScene, "--point", "1,1,1", "--by", "1,0,0", "--editor",
               std::string(300, 'x')},
              "--editor: has 300 bytes");
  ExpectWords({"edit", "set", kScene, "--point", "1,1,1", "--to", "nan,0,0"}, "--to: holds NaN ");
  ExpectWords({"edit", "drag", kScene, "--at", "0,0,1,2,0.3,0.3,0.4", "--to", "1e300,0,0"},
              "--to: got 1e+300, ");
  ExpectWords({"edit", "drag", kScene, "--at", "0,0,1,2,0.3,0.3,0.4", "--by", "0,1e300,0"},
              "--by: got 1e+300, ");
  ExpectWords({"edit", "drag", kScene, "--at", "9999,0,1,2,0.3,0.3,0.4", "--by", "1,0,0"},
              "--at, face: got 9999, ");
  ExpectWords({"edit", "drag", kScene, "--at", "9999,0,1,2,0.3,0.3,0.4", "--to", "1,0,0"},
              "--at, face: got 9999, ");
  ExpectWords({"edit", "insert-knot", kScene, "u", "5"}, "value: got 5, ");
  const auto parent = WriteLattice([](auto& lattice) { lattice["controlPoints"].erase(0); });
  ExpectWords({"edit", "carry", kScene, "--lattice", parent},
              "--lattice, controlPoints: got 191 numbers, ");
  ExpectWords({"pick", kScene, "--ray", "0,0,0,0,0,0"}, "--ray, direction: must not be zero");
}

TEST_F(LatticectlWords, AreThoseOfTheLoadGeneratorToo) {
  ExpectWords({"bench", Path("vase.obj"), "--degree", "2,2,4"}, "--degree, w: got 4, ");
}

TEST_F(LatticectlWords, WithoutAServerAreTheSame) {
  const auto expect = [](const std::vector<std::string>& arguments, const char* words) {
    EXPECT_THAT(Latticectl(arguments).err, StartsWith(std::string("latticectl: ") + words));
  };
  const std::string vase = Path("vase.obj");
  expect({"lattice", vase, "--degree", "4,2,2"}, "--degree, u: got 4, ");
  expect({"lattice", vase, "--padding", "-3"}, "--padding: got -3, ");
  const auto frame = WriteLattice([](auto& lattice) { lattice.erase("frame"); });
  expect({"apply", vase, "--lattice", frame, "-o", Path("o.ply"), "--vertices-only"},
         "--lattice, frame: is required");
}

TEST_F(LatticectlWords, ProgramsReadTheFieldAsTheServerNamesIt) {
  const RunResult result =
      Latticectl(AtServer({"scene", "create", Path("vase.obj"), "--degree", "2,5,2", "--json"}));

  const auto error = nlohmann::json::parse(result.err, nullptr, false)["error"];

  EXPECT_EQ(error["field"], "lattices[0].fit.degree.v");
  EXPECT_EQ(error["message"], "--degree, v: got 5, allowed is 1 to 3");
}

bool HasField(const google::protobuf::Descriptor* message, const std::string& path) {
  for (const auto piece : absl::StrSplit(path, '.')) {
    const auto* field = message == nullptr ? nullptr : message->FindFieldByName(std::string(piece));
    if (field == nullptr) return false;
    message = field->message_type();
  }
  return true;
}

TEST(FieldFlagsTest, EveryFieldIsOneOfARequest) {
  const google::protobuf::Descriptor* const requests[] = {
      v1::CreateSceneRequest::descriptor(),    v1::WatchRequest::descriptor(),
      v1::UploadMeshRequest::descriptor(),     v1::ListMeshesRequest::descriptor(),
      v1::ExportRequest::descriptor(),         v1::PickRequest::descriptor(),
      v1::EvaluatePointsRequest::descriptor(), v1::EditBatch::descriptor(),
      v1::LatticeSource::descriptor()};
  for (const FieldFlag& entry : FieldFlags()) {
    const std::string path(entry.field);
    EXPECT_TRUE(std::ranges::any_of(requests, [&](const auto* request) {
      return HasField(request, path);
    })) << path;
  }
}

TEST(FieldFlagsTest, EveryFlagIsAnOptionOfACommand) {
  std::ostringstream out, err;
  CLI::App app("", "latticectl");
  CommandLine line{.console = {.out = out, .err = err}};
  AddCommands(app, line);
  BenchFlags flags;
  DeclareBench(*app.get_subcommand("bench"), flags);
  const std::function<bool(const CLI::App*, const std::string&)> has =
      [&has](const CLI::App* command, const std::string& flag) {
        return command->get_option_no_throw(flag) != nullptr ||
               std::ranges::any_of(command->get_subcommands({}),
                                   [&](const CLI::App* below) { return has(below, flag); });
      };
  for (const FieldFlag& entry : FieldFlags()) {
    EXPECT_TRUE(has(&app, std::string(entry.flag))) << entry.flag;
  }
}

}  // namespace
}  // namespace latticed::client
