// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Presence between editors through the stub.
#include <functional>
#include <limits>

#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

using ::testing::ElementsAre;

constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

class PresenceTest : public SceneStreamTest {
 protected:
  static v1::DeformRequest Presence(const std::string& name, uint32_t colour = 0x3366FF) {
    v1::DeformRequest request;
    request.mutable_presence()->set_name(name);
    request.mutable_presence()->set_colour(colour);
    return request;
  }
  static v1::DeformRequest Spoilt(const std::function<void(v1::Presence&)>& spoil) {
    v1::DeformRequest request = Presence("Alice");
    spoil(*request.mutable_presence());
    return request;
  }
  absl::Status Control(const WatchClient& watcher, const v1::Presence& presence) {
    v1::ControlWatchRequest request;
    *request.mutable_presence() = presence;
    return StreamTest::Control(watcher, request);
  }
  // The status of a stream that sends `request` and nothing else.
  absl::Status StatusAfter(const v1::DeformRequest& request, const std::string& editor = "alice") {
    DeformClient client(*scenes_, Watch(editor));
    EXPECT_TRUE(client.Send(request));
    return client.Finish();
  }
};

TEST_F(PresenceTest, OthersSeeItThoseWhoComeLateToo) {
  DeformClient alice(*scenes_, Watch("alice")), bob(*scenes_, Watch("bob"));
  bob.ReadUntilRevision(0);
  v1::DeformRequest shown = Presence("Alice");
  for (const uint32_t index : {7u, 9u}) shown.mutable_presence()->add_selected_indices(index);
  shown.mutable_presence()->set_lattice(1);
  ASSERT_TRUE(alice.Send(shown));
  bob.ReadUntil([&] { return !bob.log.presences.empty(); });
  WatchClient carol(*scenes_, Watch("carol"));
  carol.ReadUntil([&] { return !carol.log.presences.empty(); });

  for (const EventLog* log : {&bob.log, &carol.log}) {
    const v1::Presence& seen = log->presences[0];
    EXPECT_EQ(seen.editor_id(), "alice");
    EXPECT_EQ(seen.name(), "Alice");
    EXPECT_EQ(seen.colour(), 0x3366FFu);
    EXPECT_THAT(seen.selected_indices(), ElementsAre(7u, 9u));
    EXPECT_EQ(seen.lattice(), 1u);
    EXPECT_FALSE(seen.left());
  }
  // If alice's own presence came back to her, it would come before carol's.
  ASSERT_OK(Control(carol, Presence("Carol").presence()));
  alice.ReadUntil([&] { return !alice.log.presences.empty(); });
  EXPECT_EQ(alice.log.presences[0].editor_id(), "carol") << "not its own";
  EXPECT_LE(alice.log.ends.size(), 1u) << "no revision, no update";
}

TEST_F(PresenceTest, OthersAreToldWhenAnEditorsLastStreamEnds) {
  WatchClient bob(*scenes_, Watch("bob"));
  bob.ReadUpdates(1);
  const auto last = [&] { return bob.log.presences.back(); };
  {
    DeformClient again(*scenes_);
    {
      DeformClient alice(*scenes_, Watch("alice"));
      ASSERT_TRUE(alice.Send(Presence("Alice")));
      bob.ReadUntil([&] { return !bob.log.presences.empty(); });
      again.Open(Watch("alice"));
      ASSERT_TRUE(again.Send(Presence("Alice, again")));
      bob.ReadUntil([&] { return last().name() == "Alice, again"; });
    }
    ASSERT_TRUE(again.Send(Presence("Alice, still")));
    bob.ReadUntil([&] { return last().name() == "Alice, still"; });
    for (const auto& presence : bob.log.presences) EXPECT_FALSE(presence.left());
    again.HalfClose();
    EXPECT_TRUE(again.Finish().ok());
  }
  bob.ReadUntil([&] { return last().left(); });
  EXPECT_EQ(last().editor_id(), "alice");
  EXPECT_EQ(last().name(), "");
  WatchClient carol(*scenes_, Watch("carol"));
  carol.ReadUpdates(1);
  EXPECT_TRUE(carol.log.presences.empty()) << "nothing is stored";
}

TEST_F(PresenceTest, ScriptsAreNotBothered) {
  DeformClient alice(*scenes_, Watch("alice"));
  ASSERT_TRUE(alice.Send(Presence("Alice")));
  WatchClient bob(*scenes_, Watch("bob"));
  bob.ReadUntil([&] { return !bob.log.presences.empty(); });
  EventLog log;
  EXPECT_OK(Update(For<v1::GetUpdateRequest>(), log));
  EXPECT_TRUE(log.presences.empty());
}

TEST_F(PresenceTest, RefusesWhatIsTooLargeOrSomebodyElses) {
  const auto expect = [&](const v1::DeformRequest& request, const std::string& reason,
                          const std::string& field, const std::string& message) {
    ExpectRefusal(StatusAfter(request), {kInvalid, reason, field, message});
  };
  expect(Presence(std::string(65, 'a')), "OUT_OF_RANGE", "presence.name", "has 65 characters");
  expect(Presence("Alice", 0x1000000), "OUT_OF_RANGE", "presence.colour", "16777215");
  expect(Spoilt([](auto& p) {
           for (int i = 0; i < 1025; ++i) p.add_selected_indices(0);
         }),
         "OUT_OF_RANGE", "presence.selected_indices", "1024");
  expect(Spoilt([](auto& p) { p.add_selected_indices(32768); }), "OUT_OF_RANGE",
         "presence.selected_indices[0]", "32767");
  expect(Spoilt([](auto& p) { p.set_lattice(8); }), "OUT_OF_RANGE", "presence.lattice", "7");
  expect(Spoilt([](auto& p) { p.set_left(true); }), "INVALID_FIELD", "presence.left", "server");
  expect(Spoilt([](auto& p) { p.set_editor_id("bob"); }), "INVALID_FIELD", "presence.editor_id",
         "not the editor");
  expect(Spoilt([](auto& p) { p.set_following("alice"); }), "INVALID_FIELD", "presence.following",
         "the editor of the watch itself");
  expect(Spoilt([](auto& p) { p.set_following(std::string(65, 'b')); }), "INVALID_FIELD",
         "presence.following", "64 bytes");
  ExpectRefusal(StatusAfter(Presence("Nobody"), ""),
                {kInvalid, "INVALID_FIELD", "presence", "no editor_id"});

  WatchClient bob(*scenes_, Watch("bob"));
  bob.ReadUpdates(1);
  ExpectRefusal(Control(bob, Presence("Bob", 0x1000000).presence()),
                {kInvalid, "OUT_OF_RANGE", "presence.colour", "16777215"});
  // The limit of 64 counts characters, not bytes. These take 3 bytes each.
  std::string name;
  for (int i = 0; i < 64; ++i) name += "\u2713";
  EXPECT_OK(Control(bob, Presence(name).presence()));
}

TEST_F(PresenceTest, OthersSeeWhomAnEditorFollowsUntilItLeaves) {
  WatchClient bob(*scenes_, Watch("bob"));
  bob.ReadUpdates(1);
  {
    DeformClient alice(*scenes_, Watch("alice"));
    const auto shown_after = [&](const std::string& followed) {
      const size_t before = bob.log.presences.size();
      v1::DeformRequest request = Presence("Alice");
      request.mutable_presence()->set_following(followed);
      EXPECT_TRUE(alice.Send(request));
      bob.ReadUntil([&] { return bob.log.presences.size() > before; });
      return bob.log.presences.back().following();
    };
    EXPECT_EQ(shown_after("bob"), "bob");
    const std::string longest(64, 'c');
    EXPECT_EQ(shown_after(longest), longest) << "somebody who is not here";
    EXPECT_EQ(shown_after(""), "") << "the newest presence is the whole";
    EXPECT_EQ(shown_after("bob"), "bob");
    WatchClient carol(*scenes_, Watch("carol"));
    carol.ReadUntil([&] { return !carol.log.presences.empty(); });
    EXPECT_EQ(carol.log.presences[0].following(), "bob");
  }
  bob.ReadUntil([&] { return bob.log.presences.back().left(); });
  v1::Presence left;
  left.set_editor_id("alice");
  left.set_left(true);
  EXPECT_EQ(bob.log.presences.back().SerializeAsString(), left.SerializeAsString());
}

v1::Camera PerspectiveCamera() {
  v1::Camera camera;
  camera.mutable_position()->set_y(-5);
  camera.mutable_target()->set_z(0.5);
  camera.mutable_up()->set_z(1);
  camera.set_fov_y(40);
  return camera;
}

TEST_F(PresenceTest, OthersSeeTheCamera) {
  WatchClient bob(*scenes_, Watch("bob"));
  bob.ReadUpdates(1);
  DeformClient alice(*scenes_, Watch("alice"));
  const auto shown_after = [&](const v1::DeformRequest& request) {
    const size_t before = bob.log.presences.size();
    EXPECT_TRUE(alice.Send(request));
    bob.ReadUntil([&] { return bob.log.presences.size() > before; });
    return bob.log.presences.back();
  };
  v1::DeformRequest request = Presence("Alice");
  v1::Camera& camera = *request.mutable_presence()->mutable_camera();

  camera = PerspectiveCamera();
  EXPECT_EQ(shown_after(request).camera().SerializeAsString(), camera.SerializeAsString());
  camera.set_height(2.5);
  EXPECT_EQ(shown_after(request).camera().SerializeAsString(), camera.SerializeAsString());
  EXPECT_FALSE(shown_after(Presence("Alice")).has_camera()) << "the newest presence is the whole";
}

// A stream keeps this much room for a small event: MostMessageBytes in server/rpc/scene_stream.cc.
TEST_F(PresenceTest, TheLargestIsBelow4KiB) {
  WatchClient bob(*scenes_, Watch("bob"));
  bob.ReadUpdates(1);
  const std::string alice(64, 'a');
  DeformClient client(*scenes_, Watch(alice));
  v1::DeformRequest request = Presence("", 0xFFFFFF);
  v1::Presence& largest = *request.mutable_presence();
  for (int i = 0; i < 64; ++i) largest.mutable_name()->append("\U0001F98A");
  for (int i = 0; i < 1024; ++i) largest.add_selected_indices(32767);
  largest.set_following(std::string(64, 'b'));
  v1::Camera& camera = *largest.mutable_camera() = PerspectiveCamera();
  for (v1::Vec3* place :
       {camera.mutable_position(), camera.mutable_target(), camera.mutable_up()}) {
    place->set_x(0.1);
    place->set_y(place->y() + 0.2);
    place->set_z(0.3);
  }
  ASSERT_TRUE(client.Send(request));
  bob.ReadUntil([&] { return !bob.log.presences.empty(); });

  v1::SceneEvent event;
  *event.mutable_presence() = bob.log.presences[0];
  largest.set_editor_id(alice);
  EXPECT_EQ(event.presence().SerializeAsString(), largest.SerializeAsString());
  EXPECT_LT(event.ByteSizeLong(), 4'096u);
}

TEST_F(PresenceTest, RefusesACameraThatShowsNothing) {
  const auto expect = [&](const std::function<void(v1::Camera&)>& spoil, const std::string& reason,
                          const std::string& field, const std::string& message) {
    SCOPED_TRACE(field + ": " + message);
    const auto request = Spoilt([&](v1::Presence& presence) {
      *presence.mutable_camera() = PerspectiveCamera();
      spoil(*presence.mutable_camera());
    });
    ExpectRefusal(StatusAfter(request), {kInvalid, reason, field, message});
  };
  const std::string field = "presence.camera";
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  expect([](auto& c) { c.mutable_position()->set_x(kNan); }, "NOT_FINITE", field + ".position",
         "NaN");
  expect([](auto& c) { c.mutable_target()->set_y(kInfinity); }, "NOT_FINITE", field + ".target",
         "infinity");
  expect([](auto& c) { c.mutable_position()->set_z(1.1e15); }, "OUT_OF_RANGE", field + ".position",
         "-1000000000000000 to 1000000000000000");
  expect([](auto& c) { c.mutable_target()->set_z(-1.1e15); }, "OUT_OF_RANGE", field + ".target",
         "-1000000000000000 to 1000000000000000");
  expect([](auto& c) { c.mutable_up()->set_z(1.1e15); }, "OUT_OF_RANGE", field + ".up",
         "-1000000000000000 to 1000000000000000");
  expect([](auto& c) { *c.mutable_target() = c.position(); }, "INVALID_FIELD", field + ".target",
         "position");
  expect([](auto& c) { c.clear_up(); }, "INVALID_FIELD", field + ".up", "zero");
  expect([](auto& c) { c.set_fov_y(kNan); }, "NOT_FINITE", field + ".fov_y", "NaN");
  for (const double degrees : {0.0, -40.0, 180.0}) {
    expect([&](auto& c) { c.set_fov_y(degrees); }, "OUT_OF_RANGE", field + ".fov_y", "179");
  }
  expect([](auto& c) { c.set_height(kNan); }, "NOT_FINITE", field + ".height", "NaN");
  for (const double height : {0.0, -1.0, 1.1e15}) {
    expect([&](auto& c) { c.set_height(height); }, "OUT_OF_RANGE", field + ".height",
           "1e-15 to 1000000000000000");
  }
  expect([](auto& c) { c.clear_projection(); }, "INVALID_FIELD", field, "fov_y or height");
}

}  // namespace
}  // namespace latticed::testing
