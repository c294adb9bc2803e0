// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/wire/view_converters.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

using ::latticed::testing::StatusIs;
using ::testing::StartsWith;

constexpr absl::StatusCode kInvalidView = absl::StatusCode::kInvalidArgument;

TEST(ViewConverter, DefaultsAreTheDocumentedOnes) {
  const auto view =
      DefaultViewFromProto(v1::ViewOptions(), DefaultView(/*mesh_has_normals=*/false), "view");

  ASSERT_OK(view);
  EXPECT_EQ(view->key.spec.segments, 10);
  EXPECT_EQ(view->key.spec.normals, NormalMode::kFacet);
  EXPECT_EQ(view->key.spec.position_bits, 12);
  EXPECT_EQ(view->key.spec.normal_bits, 8);
  EXPECT_EQ(view->key.encoding, Encoding::kDracoPoints);
  EXPECT_EQ(view->key.spec.format, VertexFormat::kQuantised);
  EXPECT_EQ(view->max_points, 0U);
  EXPECT_EQ(DefaultView(/*mesh_has_normals=*/true).key.spec.normals, NormalMode::kSmooth);
}

TEST(ViewConverter, WhatIsEmptyComesFromTheSceneAndTheRestDoesNot) {
  v1::ViewOptions scene_options;
  scene_options.set_segments(5);
  scene_options.set_position_bits(14);
  scene_options.set_encoding(v1::ENCODING_QUANTISED);
  scene_options.set_max_points(1'000);
  const auto scene = DefaultViewFromProto(scene_options, DefaultView(true), "default_view");
  ASSERT_OK(scene);
  v1::ViewOptions options;
  options.set_normals(v1::NORMAL_MODE_NONE);
  options.set_position_bits(9);
  options.set_max_bytes_per_second(77);

  const auto view = WatchViewFromProto(options, *scene, "view");

  ASSERT_OK(view);
  EXPECT_EQ(view->key.spec.segments, 5);
  EXPECT_EQ(view->key.spec.position_bits, 9);
  EXPECT_EQ(view->key.spec.normals, NormalMode::kNone);
  EXPECT_EQ(view->key.encoding, Encoding::kQuantised);
  EXPECT_EQ(view->max_points, 1'000U);
  EXPECT_EQ(view->max_bytes_per_second, 77U);
}

TEST(ViewConverter, RoundTripsThroughTheMessage) {
  v1::ViewOptions options;
  options.set_segments(32);
  options.set_normals(v1::NORMAL_MODE_SMOOTH);
  options.set_encoding(v1::ENCODING_DRACO_MESH);
  options.set_position_bits(16);
  options.set_normal_bits(6);
  options.set_max_points(5);
  options.set_max_bytes_per_second(6);
  options.set_drag_position_bits(11);
  options.set_drag_normal_bits(7);
  options.set_tolerance(0.125);

  const auto view = WatchViewFromProto(options, DefaultView(false), "view");

  ASSERT_OK(view);
  EXPECT_EQ(ToProto(*view).SerializeAsString(), options.SerializeAsString());
}

TEST(ViewConverter, ATolerancesBitsAreChosenLater) {
  v1::ViewOptions by_tolerance, by_segments, more_bits;
  by_tolerance.set_tolerance(0.5);
  by_segments.set_segments(3);
  more_bits.set_position_bits(15);
  const auto scene = DefaultViewFromProto(by_tolerance, DefaultView(false), "default_view");
  ASSERT_OK(scene);
  EXPECT_EQ(scene->key.spec.tolerance, 0.5);
  EXPECT_EQ(scene->key.spec.position_bits, 0);

  const auto same = WatchViewFromProto({}, *scene, "view");
  const auto uniform = WatchViewFromProto(by_segments, *scene, "view");
  const auto more = WatchViewFromProto(more_bits, *scene, "view");

  ASSERT_OK(same);
  EXPECT_EQ(same->key, scene->key);
  ASSERT_OK(uniform);
  EXPECT_EQ(uniform->key.spec.tolerance, 0) << "segments alone ask for a view without a tolerance";
  EXPECT_EQ(uniform->key.spec.segments, 3);
  EXPECT_EQ(uniform->key.spec.position_bits, 12);
  ASSERT_OK(more);
  EXPECT_EQ(more->key.spec.tolerance, 0.5);
  EXPECT_EQ(more->key.spec.position_bits, 15);
}

TEST(ViewConverter, BitsWithoutEffectMakeNoOtherView) {
  v1::ViewOptions raw, raw_with_bits;
  raw.set_encoding(v1::ENCODING_RAW);
  raw_with_bits.set_encoding(v1::ENCODING_RAW);
  raw_with_bits.set_position_bits(9);
  raw_with_bits.set_normal_bits(11);
  raw_with_bits.set_drag_position_bits(8);
  raw_with_bits.set_drag_normal_bits(8);

  const auto one = WatchViewFromProto(raw, DefaultView(false), "view");
  const auto other = WatchViewFromProto(raw_with_bits, DefaultView(false), "view");

  ASSERT_OK(one);
  ASSERT_OK(other);
  EXPECT_EQ(one->key, other->key);
  EXPECT_EQ(one->key.spec.format, VertexFormat::kFloat32);
  EXPECT_EQ(other->drag_position_bits, 0) << "nor while a gesture is open";
  EXPECT_EQ(other->drag_normal_bits, 0);
}

}  // namespace
}  // namespace latticed
