// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// --audit-log: one line for what each caller made, edited and deleted.
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/base/sha256.h"
#include "fmt/format.h"
#include "server/base/audit_log.h"
#include "tests/server/support/server_test.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

using ::testing::HasSubstr;

constexpr char kAda[] = "of-ada";

std::vector<nlohmann::json> Lines(const std::string& text) {
  std::vector<nlohmann::json> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    lines.push_back(nlohmann::json::parse(line));  // throws
  }
  return lines;
}
std::vector<std::string> Events(const std::vector<nlohmann::json>& lines) {
  std::vector<std::string> events;
  for (const auto& line : lines) events.push_back(line["event"]);
  return events;
}

class AuditTest : public ServerTest {
 protected:
  void SetUp() override {
    options_ = TestOptions();
    options_.token_file =
        folder_.Write("tokens", fmt::format("{} admin ada acme\n", Sha256Hex(kAda)));
    options_.audit_log = folder_.Path("audit");
    StartServer(options_);
    const std::string obj = CubeObj();
    v1::Mesh mesh;
    ASSERT_OK(Upload(ObjHeader(obj), obj, &mesh, metadata_));
    ASSERT_OK(Upload(ObjHeader(obj), obj, nullptr, metadata_)) << "the same is no new mesh";
    mesh_ = mesh.id();
    ASSERT_OK(Call(&Scenes::CreateScene, SceneRequest(), nullptr, metadata_));
    ASSERT_OK(Call(&Scenes::CreateScene, SceneRequest(), nullptr, metadata_));
  }
  std::vector<nlohmann::json> Log() const { return Lines(folder_.Read("audit")); }
  absl::Status Delete() {
    return Call(&Scenes::DeleteScene, For<v1::DeleteSceneRequest>(), nullptr, metadata_);
  }

  TemporaryFolder folder_;
  Options options_;
  Metadata metadata_ = {{"authorization", std::string("Bearer ") + kAda},
                        {"latticed-request-id", "call-1"}};
};

TEST_F(AuditTest, SaysWhoMadeEditedAndDeletedWhat) {
  for (uint64_t i = 1; i <= 3; ++i) {
    ASSERT_OK(Call(&Scenes::ApplyEdits, MoveOne("ed", i, 3, {1, 0, 0}), nullptr, metadata_));
  }
  {
    DeformClient deform(*scenes_, For<v1::WatchRequest>(), metadata_);
    ASSERT_TRUE(deform.Send(MoveOne("eve", 1, 4, {1, 0, 0})));
    ASSERT_TRUE(deform.Send(MoveOne("eve", 2, 999, {1, 0, 0})));  // there is no such point
    deform.ReadUntil([&] { return deform.log.results.size() == 2; });
  }
  EXPECT_OK(Delete());
  EXPECT_FALSE(Delete().ok());
  v1::DeleteMeshRequest remove;
  remove.set_mesh(mesh_);
  EXPECT_OK(Call(&Meshes::DeleteMesh, remove, nullptr, metadata_));
  server_.reset();

  const auto log = Log();
  ASSERT_THAT(Events(log), ::testing::ElementsAre("mesh_created", "scene_created", "scene_deleted",
                                                  "mesh_deleted", "scene_edited"));
  for (const auto& line : log) {
    EXPECT_EQ(line["tenant"], "acme");
    EXPECT_EQ(line["caller"], "ada");
    EXPECT_EQ(line["request_id"], "call-1");
    EXPECT_THAT(std::string(line["peer"]), HasSubstr("127.0.0.1"));
    absl::Time time;
    EXPECT_TRUE(absl::ParseTime(absl::RFC3339_full, std::string(line["time"]), &time, nullptr));
  }
  EXPECT_EQ(log[0]["mesh"], mesh_);
  EXPECT_EQ(log[1]["scene"], kScene);
  EXPECT_EQ(log[1]["mesh"], mesh_);
  EXPECT_EQ(log[4]["edits"], "4") << "one line for all";
}

TEST_F(AuditTest, GoesOnInANewFileAfterReload) {
  std::filesystem::rename(folder_.Path("audit"), folder_.Path("audit.1"));
  ASSERT_OK(server_->Reload(options_));
  EXPECT_OK(Delete());

  EXPECT_THAT(Events(Log()), ::testing::ElementsAre("scene_deleted"));
  EXPECT_THAT(Events(Lines(folder_.Read("audit.1"))),
              ::testing::ElementsAre("mesh_created", "scene_created"));
  struct stat file {};
  ASSERT_EQ(stat(options_.audit_log.c_str(), &file), 0);
  EXPECT_EQ(file.st_mode & 0777, 0600u);
}

TEST_F(AuditTest, AServerDoesNotStartWithoutItsFile) {
  options_.audit_log = folder_.Path("no-such-folder/audit");
  EXPECT_THAT(InProcessServer::Start(options_).status(),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("--audit-log")));
}

TEST(AuditLogTest, EditsAreOneLineUntilASilence) {
  const TemporaryFolder folder;
  AuditLog log(folder.Path("audit"));
  ASSERT_OK(log.Open());
  const absl::Time start = absl::FromUnixSeconds(1'700'000'000);
  const AuditActor ada{.tenant = "acme", .caller = "ada\xff\"\n"}, bob{.caller = "bob"};
  for (int i = 0; i < 5; ++i) log.NoteEdit(ada, "cow", start + absl::Seconds(i));
  log.NoteEdit(bob, "cow", start + absl::Seconds(9));

  log.WriteEditsBefore(start + absl::Seconds(4));
  EXPECT_EQ(folder.Read("audit"), "");
  log.WriteEditsBefore(start + absl::Seconds(5));
  log.NoteEdit(ada, "cow", start + absl::Seconds(100));
  log.WriteEditsBefore(start + absl::Hours(1));

  const auto lines = Lines(folder.Read("audit"));
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[0]["edits"], "5");
  EXPECT_EQ(lines[0]["first"], "2023-11-14T22:13:20.000Z");
  EXPECT_EQ(lines[0]["last"], "2023-11-14T22:13:24.000Z");
  EXPECT_EQ(lines[0]["caller"], "ada\xef\xbf\xbd\"\n");
  EXPECT_EQ(lines[1]["caller"], "bob");
  EXPECT_EQ(lines[2]["edits"], "1");
}

}  // namespace
}  // namespace latticed::testing
