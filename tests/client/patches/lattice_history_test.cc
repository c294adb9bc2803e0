// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Which lattice a Surface keeps for its update.
#include "client/cpp/library/patches/lattice_history.h"

#include <string>

#include "client/cpp/library/surface.h"
#include "fmt/format.h"
#include "tests/support/status_matchers.h"

namespace latticed::client {
namespace {

void ApplyOk(Surface& surface, const v1::SceneEvent& event) {
  ASSERT_OK(surface.Apply(event).status());
}
v1::SceneEvent Begin(uint64_t id) {
  v1::SceneEvent event;
  event.mutable_update_begin()->set_update_id(id);
  event.mutable_update_begin()->mutable_view()->set_encoding(v1::ENCODING_PATCHES);
  return event;
}
v1::SceneEvent End(uint64_t id, uint64_t revision) {
  v1::SceneEvent event;
  event.mutable_update_end()->set_update_id(id);
  event.mutable_update_end()->set_revision(revision);
  return event;
}
v1::SceneEvent LatticeEvent(uint64_t revision, double x) {
  v1::SceneEvent event;
  event.mutable_lattice_state()->set_revision(revision);
  for (int i = 0; i < 24; ++i)
    event.mutable_lattice_state()->mutable_lattice()->add_control_points(x);
  return event;
}
v1::SceneEvent DeltaEvent(uint64_t revision, double x) {
  v1::SceneEvent event;
  event.mutable_lattice_delta()->set_revision(revision);
  event.mutable_lattice_delta()->add_indices(0);
  for (int i = 0; i < 3; ++i) event.mutable_lattice_delta()->add_positions(x);
  return event;
}
void ApplyEmptyUpdate(Surface& surface, uint64_t id, uint64_t revision) {
  ApplyOk(surface, Begin(id));
  ApplyOk(surface, End(id, revision));
}
// "revision: first coordinate" of the update's lattice, then of the newest.
std::string LatticesOf(const Surface& surface) {
  const auto text = [](const v1::LatticeState& of) {
    const bool empty = of.lattice().control_points().empty();
    return fmt::format("{}: {}", of.revision(), empty ? -1 : of.lattice().control_points(0));
  };
  return text(surface.update_lattice()) + ", " + text(surface.lattice());
}

TEST(Surface, KeepsTheStrengthOfItsUpdate) {
  Surface surface;
  ApplyOk(surface, LatticeEvent(0, 1));
  v1::SceneEvent delta = DeltaEvent(1, 2);
  delta.mutable_lattice_delta()->set_strength(0.5);
  ApplyOk(surface, std::move(delta));
  ApplyEmptyUpdate(surface, 1, 0);
  EXPECT_FALSE(surface.update_lattice().has_strength());
  EXPECT_EQ(surface.lattice().strength(), 0.5);
  ApplyOk(surface, DeltaEvent(2, 3));  // keeps it
  ApplyEmptyUpdate(surface, 2, 2);
  EXPECT_EQ(surface.update_lattice().strength(), 0.5);
}

TEST(Surface, KeepsTheLatticeOfItsUpdate) {
  Surface surface;
  EXPECT_EQ(LatticesOf(surface), "0: -1, 0: -1");
  ApplyOk(surface, LatticeEvent(0, 1));
  EXPECT_EQ(LatticesOf(surface), "0: -1, 0: 1");
  ApplyEmptyUpdate(surface, 1, 0);
  EXPECT_EQ(LatticesOf(surface), "0: 1, 0: 1");

  for (uint64_t revision = 1; revision <= 4; ++revision)
    ApplyOk(surface, DeltaEvent(revision, 10.0 * static_cast<double>(revision)));
  EXPECT_EQ(LatticesOf(surface), "0: 1, 4: 40");
  ApplyEmptyUpdate(surface, 2, 2);
  EXPECT_EQ(LatticesOf(surface), "2: 20, 4: 40");
  ApplyEmptyUpdate(surface, 3, 4);
  EXPECT_EQ(LatticesOf(surface), "4: 40, 4: 40");

  // The lattice as a whole, before and after the revision of an update.
  ApplyOk(surface, LatticeEvent(6, 60));
  ApplyOk(surface, DeltaEvent(7, 70));
  ApplyEmptyUpdate(surface, 4, 6);
  EXPECT_EQ(LatticesOf(surface), "6: 60, 7: 70");
  ApplyOk(surface, LatticeEvent(9, 90));
  ApplyEmptyUpdate(surface, 5, 8);
  EXPECT_EQ(LatticesOf(surface), "9: 90, 9: 90") << "8 was skipped";
}

TEST(Surface, BeginsAgainWithAServerThatWasRestarted) {
  Surface surface;
  ApplyOk(surface, LatticeEvent(50, 5));
  ApplyEmptyUpdate(surface, 1, 50);
  ApplyOk(surface, DeltaEvent(51, 6));
  ApplyOk(surface, LatticeEvent(0, 1));
  ApplyEmptyUpdate(surface, 1, 0);

  EXPECT_EQ(LatticesOf(surface), "0: 1, 0: 1");
}

}  // namespace
}  // namespace latticed::client
