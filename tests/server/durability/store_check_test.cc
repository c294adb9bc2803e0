// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The program that `latticectl store check` starts, on folders of servers that run, have ended, or are damaged.
#include <sys/wait.h>

#include <array>
#include <atomic>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

#include "server/store/sqlite/database/database.h"
#include "tests/server/support/server_test.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

// Flips a bit of the byte in the middle of the last `text` of the file.
void FlipBit(const std::string& path, const std::string& text) {
  std::ifstream in(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), {}};
  const size_t at = bytes.rfind(text);
  ASSERT_NE(at, std::string::npos) << path;
  bytes[at + text.size() / 2] ^= 4;
  std::ofstream(path, std::ios::binary) << bytes;
}

class StoreCheckTest : public SceneFixture {
 protected:
  struct Checked {
    int code = -1;
    std::string out;  // with errors
  };

  // Two scenes, three records.
  void SetUp() override {
    Start();
    ASSERT_OK(Create(SceneRequest()));
    ASSERT_OK(Create(SceneRequest("scene-two")));
    ASSERT_OK(Apply(Move("ann", 1, 5, 0.1)));
    ASSERT_OK(Apply(Move("ann", 2, 5, 0.1)));
    auto last = Move("the-last-editor", 1, 6, 0.1);
    last.set_scene("scene-two");
    ASSERT_OK(Apply(last));
  }
  void Start() {
    server_.reset();
    Options options;
    options.data_dir = folder_.Path("data");
    SceneFixture::StartServer(options);
  }
  Checked Check() const { return CheckFolder(folder_.Path("data")); }
  static Checked CheckFolder(const std::string& folder) {
    const std::string command =
        std::string(LATTICECTL_STORE_BINARY) + " check '" + folder + "' 2>&1";
    FILE* const pipe = popen(command.c_str(), "r");
    Checked checked;
    std::array<char, 4096> buffer{};
    while (const size_t bytes = fread(buffer.data(), 1, buffer.size(), pipe)) {
      checked.out.append(buffer.data(), bytes);
    }
    checked.code = WEXITSTATUS(pclose(pipe));
    return checked;
  }
  // With right sums of pages.
  void ChangeDatabase(const char* sql) const {
    auto database = OpenDatabase(Database(), /*sync=*/false);
    ASSERT_OK(database);
    ASSERT_OK(database->Execute(sql));
  }
  std::string Database() const { return folder_.Path("data/latticed.sqlite"); }
  std::string MeshFile() const { return folder_.Path("data/meshes/" + mesh_); }

  TemporaryFolder folder_;
};

constexpr char kWhole[] =
    "scenes         2\nsnapshots      0\nrecords        3\nmeshes         1\n"
    "mesh bytes     226\nunknown files  0\nall is whole\n";

TEST_F(StoreCheckTest, AFolderOfAServerThatRunsAndOneThatHasEndedAreWhole) {
  const Checked running = Check();
  EXPECT_EQ(running.code, 0);
  EXPECT_EQ(running.out, kWhole);

  ASSERT_OK(Apply(Move("ann", 3, 5, 0.1)));  // the server goes on
  server_.reset();
  folder_.Write("data/meshes/new-7", "left by a crash");

  const Checked ended = Check();
  EXPECT_EQ(ended.code, 0);
  EXPECT_THAT(ended.out, AllOf(HasSubstr("records        4\n"), HasSubstr("unknown files  1\n"),
                               EndsWith("all is whole\n")));
}

TEST_F(StoreCheckTest, NothingLooksDamagedWhileEditsAreWritten) {
  std::atomic<bool> stop = false;
  std::atomic<uint64_t> edits = 0;
  std::thread editor([&] {
    for (uint64_t sequence = 3; !stop; ++sequence) {
      ASSERT_OK(Apply(Move("ann", sequence, 5, 0.1)));
      ++edits;
    }
  });
  for (int i = 0; i < 10; ++i) {
    const Checked checked = Check();
    EXPECT_EQ(checked.code, 0) << checked.out;
  }
  stop = true;
  editor.join();
  EXPECT_GT(edits, 10u);
  server_.reset();
  EXPECT_THAT(Check().out, HasSubstr("records        " + std::to_string(3 + edits) + "\n"));
}

TEST_F(StoreCheckTest, AServerStartsOnAFolderThatWasChecked) {
  server_.reset();
  EXPECT_EQ(Check().code, 0);
  Start();
  EXPECT_EQ(Get().revision(), 2u);
  server_.reset();
  EXPECT_EQ(Check().out, kWhole);
}

TEST_F(StoreCheckTest, EditsThatAreOnlyInTheLogOfAKilledServerAreRead) {
  // The files as a kill leaves them: the log has everything, its index is gone.
  const std::string copy = folder_.Path("killed");
  std::filesystem::create_directories(copy);
  std::filesystem::copy(folder_.Path("data"), copy, std::filesystem::copy_options::recursive);
  std::filesystem::remove(copy + "/latticed.sqlite-shm");
  const auto log_bytes = std::filesystem::file_size(copy + "/latticed.sqlite-wal");
  ASSERT_GT(log_bytes, 0u);

  EXPECT_EQ(CheckFolder(copy).out, kWhole);

  EXPECT_EQ(std::filesystem::file_size(copy + "/latticed.sqlite-wal"), log_bytes);
}

TEST_F(StoreCheckTest, AFlippedBitOfAMeshIsNamed) {
  server_.reset();
  FlipBit(MeshFile(), "g high");

  const Checked checked = Check();

  EXPECT_EQ(checked.code, 1);
  EXPECT_THAT(checked.out, HasSubstr("damage         mesh " + mesh_ +
                                     " is damaged: its bytes have another hash\n"));
}

TEST_F(StoreCheckTest, AMissingMeshAndAMissingRowOfItAreNamed) {
  server_.reset();
  std::filesystem::remove(MeshFile());
  Checked checked = Check();
  EXPECT_EQ(checked.code, 1);
  EXPECT_THAT(checked.out, HasSubstr("damage         mesh " + mesh_ + " is damaged: "));

  ChangeDatabase("DELETE FROM mesh");
  checked = Check();
  EXPECT_EQ(checked.code, 1);
  for (const char* scene : {"scene-one", "scene-two"}) {
    EXPECT_THAT(checked.out, HasSubstr("damage         scene '" + std::string(scene) +
                                       "': its mesh " + mesh_ + " is missing\n"));
  }
}

TEST_F(StoreCheckTest, AChangedRecordIsNamedAndTheOtherSceneIsRead) {
  server_.reset();
  ChangeDatabase("UPDATE record SET bytes = zeroblob(length(bytes)) WHERE lsn = 2");

  const Checked checked = Check();

  EXPECT_EQ(checked.code, 1);
  EXPECT_THAT(checked.out,
              AllOf(HasSubstr("records        1\n"),
                    HasSubstr("damage         scene 'scene-one': record 2 is damaged: its bytes "
                              "are not those that were written\n"),
                    Not(HasSubstr("scene-two"))));
}

TEST_F(StoreCheckTest, AFlippedBitOfThePageOfARecordIsFound) {
  server_.reset();
  FlipBit(Database(), "the-last-editor");

  const Checked checked = Check();

  EXPECT_EQ(checked.code, 1);
  EXPECT_THAT(checked.out, AllOf(HasSubstr("damage         "), HasSubstr("latticed.sqlite"),
                                 HasSubstr("is damaged"), Not(HasSubstr("all is whole"))));
}

TEST_F(StoreCheckTest, ANewerFolderAForeignOneAndNoneAreRefusedInASentence) {
  server_.reset();
  ChangeDatabase("PRAGMA user_version = 3");
  Checked checked = Check();
  EXPECT_EQ(checked.code, 1);
  EXPECT_THAT(checked.out, AllOf(StartsWith("latticectl: "),
                                 EndsWith("has schema 3, and this latticed knows up to 2: use the "
                                          "newer latticed that wrote it\n")));

  folder_.Write("other/latticed.sqlite", std::string(4096, 'x'));
  checked = CheckFolder(folder_.Path("other"));
  EXPECT_EQ(checked.code, 1);
  EXPECT_THAT(checked.out, HasSubstr("is not a database of latticed"));

  checked = CheckFolder(folder_.Path("none"));
  EXPECT_EQ(checked.code, 1);
  EXPECT_EQ(checked.out,
            "latticectl: " + folder_.Path("none") + " has no store: there is no latticed.sqlite\n");
  EXPECT_FALSE(std::filesystem::exists(folder_.Path("none")));
}

}  // namespace
}  // namespace latticed::testing
