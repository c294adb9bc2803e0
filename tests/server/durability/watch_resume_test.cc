// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A watcher whose server is started again on the same folder, or whose scene goes to another server, is sent what it
// misses and no more, in every kind of view, if the successor makes the same bytes from the same lattice; else everything.
#include <algorithm>
#include <filesystem>
#include <memory>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/cpu/cpu_backend.h"
#include "fmt/format.h"
#include "server/base/version.h"
#include "server/store/shared_memory_store.h"
#include "tests/server/support/server_test.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kCorner = 0, kMiddle = 62, kOpposite = 124, kPointCount = 125;  // of 5 x 5 x 5
constexpr uint32_t kSeedOfResuming = 41;

enum class Successor { kOnTheSameFolder, kAnotherServer };

struct KindOfView {
  const char* name;
  v1::Encoding encoding;
  double tolerance;
  int segments;
};
// The last tolerance is doubled several times: 2 segments allow few points.
constexpr KindOfView kKinds[] = {{"Uniform", v1::ENCODING_QUANTISED, 0, 4},
                                 {"Tolerance", v1::ENCODING_DRACO_POINTS, 2e-4, 32},
                                 {"FewPoints", v1::ENCODING_RAW, 1e-5, 2},
                                 {"Patches", v1::ENCODING_PATCHES, 0, 4}};

// All that a watcher has of the surface.
struct Picture {
  std::map<uint32_t, std::string> chunks, levels;
  std::vector<uint8_t> bounds;
  friend bool operator==(const Picture&, const Picture&) = default;
};

class VersionedBackend : public Backend {
 public:
  explicit VersionedBackend(std::string version) : version_(std::move(version)) {}
  std::string_view name() const override { return inner_->name(); }
  std::string description() const override { return inner_->description(); }
  std::vector<DeviceState> devices() const override { return inner_->devices(); }
  std::string Arithmetic(Pipeline /*pipeline*/) const override { return version_; }
  absl::StatusOr<std::shared_ptr<DeformTarget>> Prepare(std::shared_ptr<const DeformPlan> plan,
                                                        Pipeline pipeline) override {
    return inner_->Prepare(std::move(plan), pipeline);
  }

 private:
  const std::string version_;
  const std::unique_ptr<Backend> inner_ = MakeCpuBackend({.threads = 1});
};

class WatchResumeTest : public StreamTest {
 protected:
  void SetUp() override {
    if (Commit() == "unknown")
      GTEST_SKIP() << "built outside of git: no build is known to be the same";
    Restart();
    CreateScene(/*cells=*/32);
    // A flat patch hides how its neighbours choose its pattern.
    std::mt19937 random(kSeedOfResuming);
    std::uniform_real_distribution<double> uniform(-0.05, 0.05);
    v1::EditBatch bend = Move(++revision_, 0, uniform(random));
    for (uint32_t point = 1; point < kPointCount; ++point) {
      *bend.add_edits() = Move(1, point, uniform(random)).edits(0);
    }
    ASSERT_OK(Apply(bend));
  }
  // Ends the server, and starts its successor, with an evaluator whose library has this version.
  void Restart(const std::string& version = "1") {
    if (server_ != nullptr) server_->Drain();
    server_.reset();
    Options options = TestOptions();
    options.memory_bytes = uint64_t{256} << 20;  // an encoder of 32 segments
    options.heartbeat_interval = kHeartbeat;
    auto backend = std::make_unique<VersionedBackend>(version);
    if (successor_ == Successor::kOnTheSameFolder) {
      options.data_dir = folder_.Path("data");
      StartServerOn(std::move(backend), options);
      return;
    }
    options.advertise = fmt::format("server-{}", ++servers_);
    StartServerOn(std::move(backend), options,
                  std::make_shared<SharedMemoryStore>(memory_, options.advertise));
  }
  v1::WatchRequest WatchKind() const {
    v1::WatchRequest request = Watch();
    v1::ViewOptions& view = *request.mutable_view();
    view.set_encoding(kind_.encoding);
    view.set_tolerance(kind_.tolerance);
    view.set_segments(kind_.segments);
    return request;
  }
  // What a watcher is sent until it has the newest revision.
  EventLog Seen(const std::string& token = "") {
    v1::WatchRequest request = WatchKind();
    request.set_resume_token(token);
    WatchClient watcher(*scenes_, request);
    watcher.ReadUntilRevision(revision_);
    return watcher.log;
  }
  void Edit(uint32_t point, double dz = 0.05) { ASSERT_OK(Apply(Move(++revision_, point, dz))); }
  // So far that neighbours choose other levels, and not out of the quantisation box.
  void EditInwards(std::mt19937& random) {
    std::uniform_real_distribution<double> uniform(0, 0.2);
    const uint32_t point = random() % kPointCount;
    Edit(point, point < kMiddle ? uniform(random) : -uniform(random));
  }
  void Undo() {
    v1::EditBatch undo = Move(++revision_, kCorner, 0);
    undo.mutable_edits(0)->mutable_undo();
    ASSERT_OK(Apply(undo));
  }
  static Picture PictureOf(const EventLog& log) { return {log.chunks, log.levels, log.bounds}; }
  // Adds what a stream has sent.
  static void Add(const EventLog& log, Picture& picture) {
    for (const auto& [index, data] : log.chunks) picture.chunks[index] = data;
    for (const auto& [index, levels] : log.levels) picture.levels[index] = levels;
    for (const v1::SceneEvent& event : log.events) {
      for (const v1::Chunk& chunk : event.chunks().chunks()) {
        if (log.begins.back().view().encoding() != v1::ENCODING_PATCHES) continue;
        const size_t end = chunk.first_edge() + chunk.data().size();
        picture.bounds.resize(std::max(picture.bounds.size(), end));
        std::ranges::copy(chunk.data(), picture.bounds.begin() + chunk.first_edge());
      }
    }
  }
  // Watches again with the token of the last update, and compares what the watcher then has with what a new one gets.
  struct Resumed {
    bool resumed;
    size_t sent, all;  // chunks
    Picture picture;
    std::string token;
  };
  Resumed Resume(const Picture& before, const std::string& token) {
    const EventLog again = Seen(token), fresh = Seen();
    Resumed result{.resumed = again.hello.resumed(),
                   .sent = again.begins.at(0).chunk_count(),
                   .all = fresh.begins.at(0).chunk_count(),
                   .picture = {},
                   .token = again.ends.back().resume_token()};
    EXPECT_EQ(again.begins.size(), 1u);
    EXPECT_GT(result.all, 10u);
    if (result.resumed) result.picture = before;
    Add(again, result.picture);
    EXPECT_TRUE(result.picture == PictureOf(fresh));
    return result;
  }
  Resumed Resume(const EventLog& before) {
    return Resume(PictureOf(before), before.ends.back().resume_token());
  }
  void ExpectPart(const Resumed& resumed) {
    EXPECT_TRUE(resumed.resumed);
    EXPECT_GT(resumed.sent, 0u);
    EXPECT_LT(resumed.sent, resumed.all);
  }

  Successor successor_ = Successor::kOnTheSameFolder;
  KindOfView kind_ = kKinds[0];
  TemporaryFolder folder_;
  const std::shared_ptr<SharedMemory> memory_ = std::make_shared<SharedMemory>();
  int servers_ = 0;
  uint64_t revision_ = 0;
};

class WatchEveryViewTest : public WatchResumeTest,
                           public ::testing::WithParamInterface<std::tuple<KindOfView, Successor>> {
 protected:
  WatchEveryViewTest() { std::tie(kind_, successor_) = GetParam(); }
};

TEST_P(WatchEveryViewTest, NothingIsSentAgain) {
  Edit(kCorner);
  const EventLog before = Seen();
  EXPECT_EQ(before.ends.back().certified_error() > kind_.tolerance, kind_.segments == 2);

  Restart();
  const Resumed resumed = Resume(before);

  EXPECT_TRUE(resumed.resumed);
  EXPECT_EQ(resumed.sent, 0u);
}

TEST_P(WatchEveryViewTest, AllIsSentByAnotherVersionOfALibrary) {
  Edit(kCorner);
  const EventLog before = Seen();

  Restart("2");
  const Resumed resumed = Resume(before);

  EXPECT_FALSE(resumed.resumed);
  EXPECT_EQ(resumed.sent, resumed.all);
}

TEST_P(WatchEveryViewTest, EditsBeforeAndAfterTheEndAreSent) {
  Edit(kCorner);
  const EventLog before = Seen();
  Edit(kOpposite);  // nobody watches

  Restart();
  ExpectPart(Resume(before));

  const EventLog since = Seen();
  Edit(kMiddle);
  Restart();
  Edit(kCorner);
  const Resumed resumed = Resume(since);
  EXPECT_TRUE(resumed.resumed);
  EXPECT_GT(resumed.sent, 0u);
}

TEST_P(WatchEveryViewTest, AnUndoneMoveIsSent) {
  Edit(kCorner);
  const EventLog before = Seen();
  Undo();

  Restart();
  ExpectPart(Resume(before));
}

TEST_P(WatchEveryViewTest, AnotherStructureSendsAll) {
  const EventLog before = Seen();
  v1::EditBatch knot = Move(++revision_, 0, 0);
  knot.mutable_edits(0)->mutable_insert_knot()->set_axis(v1::LATTICE_AXIS_U);
  knot.mutable_edits(0)->mutable_insert_knot()->set_value(0.3);
  ASSERT_OK(Apply(knot));
  const EventLog since = Seen();
  ++structure_id_;
  Edit(1 + 6 * (1 + 5 * 2));  // of 6 x 5 x 5

  Restart();
  const Resumed all = Resume(before);
  EXPECT_FALSE(all.resumed);
  EXPECT_EQ(all.sent, all.all);
  ExpectPart(Resume(since));
}

// The watcher's picture lives through all servers, and is compared after each.
TEST_P(WatchEveryViewTest, RandomEditsAndEndsLeaveTheRightPicture) {
  std::mt19937 random(kSeedOfResuming);
  const EventLog first = Seen();
  Picture picture = PictureOf(first);
  std::string token = first.ends.back().resume_token();
  size_t resumed = 0, sent = 0, all = 0, undoable = 0;
  for (int round = 0; round < 12; ++round) {
    SCOPED_TRACE(fmt::format("round {}, seed {}", round, kSeedOfResuming));
    // Those before the end of the server, those after it, and sometimes another watcher between them.
    for (uint64_t edits = random() % 3; edits > 0; --edits) {
      if (undoable > 0 && random() % 4 == 0) {
        Undo();
        --undoable;
      } else {
        EditInwards(random);
        ++undoable;
      }
    }
    if (round % 3 != 2) Restart();
    if (round % 2 == 0) Seen();
    if (random() % 2 == 0) EditInwards(random);
    const Resumed again = Resume(picture, token);
    picture = again.picture;
    token = again.token;
    resumed += again.resumed ? 1 : 0;
    sent += again.sent;
    all += again.all;
  }
  EXPECT_GT(resumed, 9u) << "another quantisation box may send all";
  EXPECT_LT(sent, all);
}

INSTANTIATE_TEST_SUITE_P(
    All, WatchEveryViewTest,
    ::testing::Combine(::testing::ValuesIn(kKinds),
                       ::testing::Values(Successor::kOnTheSameFolder, Successor::kAnotherServer)),
    [](const auto& info) {
      return std::string(std::get<0>(info.param).name) +
             (std::get<1>(info.param) == Successor::kAnotherServer ? "OnAnother" : "OnTheSame");
    });

// As after a loss of power without durable commits, or a failover that lost some.
TEST_F(WatchResumeTest, AStoreThatWentBackSendsAll) {
  Edit(kCorner);
  server_.reset();
  std::filesystem::copy(folder_.Path("data"), folder_.Path("older"),
                        std::filesystem::copy_options::recursive);
  Restart();
  Edit(kMiddle);
  const EventLog before = Seen();
  server_.reset();
  std::filesystem::remove_all(folder_.Path("data"));
  std::filesystem::rename(folder_.Path("older"), folder_.Path("data"));
  Restart();
  --revision_;
  Edit(kOpposite);  // the same revision
  Edit(kCorner);

  EXPECT_FALSE(Resume(before).resumed);
}

TEST_F(WatchResumeTest, ATokenOfASceneThatWasMadeAgainResumesNothing) {
  const EventLog before = Seen();
  v1::DeleteSceneRequest request;
  request.set_scene(kScene);
  ASSERT_OK(Call(&Scenes::DeleteScene, request, nullptr));
  Restart();
  CreateScene(/*cells=*/32);
  revision_ = 0;

  EXPECT_FALSE(Resume(before).resumed);
}

}  // namespace
}  // namespace latticed::testing
