// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Restores of bytes that no server wrote: they are refused in a sentence, nothing of the item is kept, and the server goes
// on. LATTICED_BACKUP_FLIPS sets how many random changes are tried: 300, and 20,000 in a whole run.
#include <cstdlib>
#include <functional>
#include <limits>
#include <random>

#include "server/store/records/scene_log.pb.h"
#include "tests/server/backup/backup_fixture.h"

namespace latticed::testing {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;

constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

int Flips() {
  const char* flips = std::getenv("LATTICED_BACKUP_FLIPS");
  return flips == nullptr ? 300 : std::atoi(flips);
}

class HostileBackupTest : public BackupFixture {
 protected:
  void SetUp() override {
    StartEmpty(nullptr, TestOptions());
    mesh_ = Upload(kGridObj);
    ASSERT_OK(Create(SceneRequest()));
    ASSERT_OK(Apply(Move("ann", 1, 5, 0.1)));
    ASSERT_OK(Apply(Knot("ann", 2)));
    ASSERT_OK(Apply(UndoMine("ann", 3)));
    auto parts = Backup();
    ASSERT_OK(parts);
    parts_ = *std::move(parts);
    items_ = ItemsOf(parts_);
    ASSERT_EQ(items_.size(), 2u);
    StartEmpty(nullptr, TestOptions());
  }
  // Restores the scene with another history, and a checksum that fits.
  absl::Status RestoreWith(const std::function<void(store::Image&)>& change) {
    store::Image image;
    EXPECT_TRUE(image.ParseFromString(items_[1].content()));
    change(image);
    auto items = items_;
    items[1].data = items[1].header() + image.SerializeAsString();
    uint64_t records = image.records();
    for (const store::Image& other : image.others()) records += other.records();
    items[1].item.set_records(records);
    Fit(items[1]);
    return Restore(PartsOf(items)).status();
  }
  void ExpectNothing() {
    EXPECT_EQ(SceneCount(), 0);
    EXPECT_OK(Restore(parts_)) << "the server goes on";
  }

  BackupParts parts_;
  std::vector<BackedUp> items_;  // the mesh and the scene
};

TEST_F(HostileBackupTest, ChangedBytesAreNoticedByTheirChecksum) {
  const auto seed = std::random_device{}();
  SCOPED_TRACE(fmt::format("seed {}", seed));
  std::mt19937 random(seed);
  for (int flip = 0; flip < Flips() && !HasFailure(); ++flip) {
    auto items = items_;
    std::string& data = items[random() % 2].data;
    data[random() % data.size()] ^= static_cast<char>(1 << random() % 8);
    const absl::Status status = Restore(PartsOf(items)).status();
    ExpectRefused(status, kInvalid, "HASH_MISMATCH", "part");
    EXPECT_EQ(SceneCount(), 0);
  }
  ExpectNothing();
}

// The checksum fits: whoever makes such bytes is refused, or gets a scene that works.
TEST_F(HostileBackupTest, AnyBytesLeaveAServerThatWorks) {
  const auto seed = std::random_device{}();
  SCOPED_TRACE(fmt::format("seed {}", seed));
  std::mt19937 random(seed);
  int restored = 0;
  for (int flip = 0; flip < Flips() && !HasFailure(); ++flip) {
    auto items = items_;
    BackedUp& of = items[random() % 8 == 0 ? 0 : 1];
    for (uint32_t changes = 1 + random() % 3; changes > 0; --changes) {
      of.data[random() % of.data.size()] = static_cast<char>(random());
    }
    if (random() % 4 == 0) of.data.resize(of.item.header_bytes() + random() % of.content().size());
    if (random() % 4 == 0) of.data.insert(random() % of.data.size(), random() % 9, 'x');
    Fit(of);
    const absl::Status status = Restore(PartsOf(items)).status();
    if (!status.ok()) {
      EXPECT_THAT(status.code(),
                  AnyOf(kInvalid, absl::StatusCode::kNotFound, absl::StatusCode::kResourceExhausted,
                        absl::StatusCode::kUnimplemented))
          << status;
      EXPECT_FALSE(status.message().empty());
      EXPECT_EQ(SceneCount(), 0) << status;
      continue;
    }
    ++restored;
    EXPECT_EQ(SceneCount(), 1);
    EXPECT_OK(Export(For<v1::ExportRequest>()));
    v1::EditBatch edit = Move("bob", 1, 3, 0.5);
    edit.set_structure_id(Lattice().structure_id());
    Apply(edit).IgnoreError();
    for (uint64_t n = 100; n < 104; ++n) Apply(UndoMine("ann", n)).IgnoreError();
    for (uint64_t n = 104; n < 108; ++n) Apply(RedoMine("ann", n)).IgnoreError();
    EXPECT_OK(Export(For<v1::ExportRequest>()));
    EXPECT_OK(DeleteScene());
  }
  EXPECT_GT(restored, 0);
  printf("%d changes, %d scenes\n", Flips(), restored);
  ExpectNothing();
}

TEST_F(HostileBackupTest, AHistoryThatCannotBeIsRefused) {
  const std::vector<std::pair<const char*, std::function<void(store::Image&)>>> changes = {
      {"out of range", [](store::Image& image) { image.set_revision(~uint64_t{0}); }},
      {"out of range", [](store::Image& image) { image.set_clock(~uint64_t{0} - 5); }},
      {"out of range", [](store::Image& image) { image.set_structure_id(0); }},
      {"of the future", [](store::Image& image) { image.set_clock(0); }},
      {"a time", [](store::Image& image) { image.set_now(std::numeric_limits<int64_t>::max()); }},
      {"its times", [](store::Image& image) { image.set_commit_time(-1); }},
      {"a time",
       [](store::Image& image) {
         image.mutable_steps(0)->set_last_heard(std::numeric_limits<int64_t>::min());
       }},
      {"box", [](store::Image& image) { image.mutable_box()->set_range(0); }},
      {"box",
       [](store::Image& image) {
         image.mutable_box()->set_x(std::numeric_limits<double>::quiet_NaN());
       }},
      {"control",
       [](store::Image& image) {
         image.mutable_base()->set_control_points(0, std::numeric_limits<double>::infinity());
       }},
      {"size", [](store::Image& image) { image.mutable_base()->set_size(0, 1'000'000); }},
  };
  for (const auto& [why, change] : changes) {
    const absl::Status status = RestoreWith(change);
    ExpectRefused(status, kInvalid, "MALFORMED_FILE", "part");
    EXPECT_THAT(std::string(status.message()), HasSubstr(why));
    EXPECT_THAT(std::string(status.message()), HasSubstr("scene 'scene-one'"));
  }
  ExpectNothing();
}

// Undo of such a step would write to a lattice that the scene does not have.
TEST_F(HostileBackupTest, EditsOfALatticeThatIsNotThereAreRefused) {
  StartEmpty(nullptr, TestOptions());
  mesh_ = Upload(kGridObj);
  ASSERT_OK(Create(SceneRequest()));
  ASSERT_OK(Apply(Move("ann", 1, 5, 0.1)));
  v1::EditBatch add = Move("ann", 2, 0, 0);
  add.set_lattice(1);
  v1::Lattice& lattice = *add.mutable_edits(0)->mutable_replace_lattice()->mutable_lattice();
  SetFrame(*lattice.mutable_frame(), {-1, -1, -1}, {4, 4, 2});
  ASSERT_OK(Apply(add));
  ASSERT_OK_AND_ASSIGN(parts_, Backup());
  items_ = ItemsOf(parts_);
  StartEmpty(nullptr, TestOptions());
  ASSERT_OK(RestoreWith([](store::Image&) {}));
  ASSERT_OK(DeleteScene());

  for (const bool of_the_first : {true, false}) {
    const absl::Status status = RestoreWith([&](store::Image& image) {
      store::Image& gone = of_the_first ? image : *image.mutable_others(0);
      gone.set_absent(true);
      if (of_the_first) return;
      store::Step step = image.steps(0);  // which moves a point
      step.set_structure_step(0);
      gone.clear_steps();
      *gone.add_steps() = step;
    });
    ExpectRefused(status, kInvalid, "MALFORMED_FILE", "part");
    EXPECT_THAT(std::string(status.message()), HasSubstr("a lattice that was removed"));
  }
  ExpectNothing();
}

// Two bytes of a message become a step of several hundred.
TEST_F(HostileBackupTest, BytesThatGrowAreRefusedForWantOfMemory) {
  Options options = TestOptions();
  options.memory_bytes = uint64_t{8} << 20;
  options.max_mesh_bytes = uint64_t{1} << 20;
  StartEmpty(nullptr, options);
  store::Image image;
  ASSERT_TRUE(image.ParseFromString(items_[1].content()));
  std::string content = image.SerializeAsString();
  for (int n = 0; n < 10'000; ++n) content += std::string("\x22\x00", 2);  // an empty step
  items_[1].data = items_[1].header() + content;
  Fit(items_[1]);

  const absl::Status status = Restore(PartsOf(items_)).status();

  ExpectRefused(status, absl::StatusCode::kResourceExhausted, "OUT_OF_MEMORY");
  ExpectNothing();
}

TEST_F(HostileBackupTest, ABoxThatIsTooSmallIsMadeAnew) {
  ASSERT_OK(RestoreWith([](store::Image& image) { image.mutable_box()->set_range(0x1p-60); }));

  EventLog log;
  v1::GetUpdateRequest request = For<v1::GetUpdateRequest>();
  EXPECT_OK(Update(request, log));
  EXPECT_EQ(Get().revision(), 3u);
}

TEST_F(HostileBackupTest, PartsOutOfOrderAreRefused) {
  const BackupParts good = PartsOf(items_);
  const BackupParts meshes = PartsOf({items_[0]});
  const auto expect = [&](const BackupParts& parts, const char* why) {
    const absl::Status status = Restore(parts).status();
    ExpectRefused(status, kInvalid, "MALFORMED_FILE", "part");
    EXPECT_THAT(std::string(status.message()), HasSubstr(why));
  };
  expect({good.begin() + 1, good.end()}, "the start");
  expect({meshes.begin(), meshes.end() - 1}, "no end");
  expect({good.begin(), good.begin() + 2}, "ends in it");
  BackupParts parts = good;
  parts.insert(parts.begin() + 1, good[0]);
  expect(parts, "twice");
  parts = good;
  parts.erase(parts.begin() + 2);  // the mesh's data
  expect(parts, "before all of its data");
  parts = good;
  parts.insert(parts.begin() + 3, good[2]);
  expect(parts, "of no item");
  parts = meshes;
  parts.push_back(meshes.back());
  expect(parts, "after the end");
  parts = meshes;
  parts.back().mutable_end()->set_parts(17);
  expect(parts, "17");
  parts = good;
  parts[1].mutable_item()->set_header_bytes(~uint64_t{0});
  expect(parts, "a header of");
  parts = good;
  parts[1].Clear();
  expect(parts, "not known");
  parts = good;
  parts[0].mutable_start()->set_format(2);
  ExpectRefused(Restore(parts).status(), absl::StatusCode::kFailedPrecondition, "UNSUPPORTED");
  ASSERT_OK(DeleteMesh(mesh_));
  items_.erase(items_.begin());
  const absl::Status no_mesh = Restore(PartsOf(items_)).status();
  ExpectRefused(no_mesh, absl::StatusCode::kNotFound, "NOT_FOUND");
  EXPECT_THAT(std::string(no_mesh.message()), HasSubstr(mesh_));
  ExpectNothing();
}

TEST_F(HostileBackupTest, ARestoreWithoutOptionsIsRefused) {
  grpc::ClientContext context;
  v1::RestoreResponse response;
  const auto stub = Backups();
  const auto writer = stub->Restore(&context, &response);
  v1::RestoreRequest request;
  *request.mutable_part() = parts_[0];
  writer->Write(request);
  writer->WritesDone();
  ExpectRefused(client::FromGrpc(writer->Finish()), absl::StatusCode::kFailedPrecondition,
                "STREAM_NOT_OPENED");
}

TEST_F(HostileBackupTest, WhatDoesNotFitInMemoryIsRefused) {
  items_[0].item.set_content_bytes(uint64_t{15} << 20);
  ExpectRefused(Restore(PartsOf(items_)).status(), kInvalid, "MALFORMED_FILE", "part");
  StartEmpty(nullptr);
  const std::string large = Upload(PlaneObj(300));
  ASSERT_OK_AND_ASSIGN(const BackupParts parts, Backup());
  Options options = TestOptions();
  options.memory_bytes = uint64_t{16} << 20;
  StartEmpty(nullptr, options);

  const absl::Status status = Restore(parts).status();

  ExpectRefused(status, absl::StatusCode::kResourceExhausted, "OUT_OF_MEMORY");
  EXPECT_THAT(std::string(status.message()), HasSubstr("mesh " + large));
  EXPECT_EQ(MeshCount(), 0);
  ExpectNothing();
}

}  // namespace
}  // namespace latticed::testing
