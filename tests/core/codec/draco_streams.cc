// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/core/codec/draco_streams.h"

#include <gtest/gtest.h>

#include <array>
#include <memory>

#include "core/codec/draco_decode.h"
#include "draco/compression/decode.h"
#include "draco/compression/encode.h"
#include "draco/metadata/geometry_metadata.h"
#include "fmt/format.h"

namespace latticed::testing {
namespace {

using Attribute = draco::GeometryAttribute;

std::string Encode(const draco::Mesh& mesh, draco::MeshEncoderMethod method) {
  draco::Encoder encoder;
  encoder.SetEncodingMethod(method);
  encoder.SetSpeedOptions(3, 3);  // edgebreaker with tables of its own for each attribute
  encoder.SetAttributeQuantization(Attribute::POSITION, 12);
  encoder.SetAttributeQuantization(Attribute::NORMAL, 8);
  encoder.SetAttributeQuantization(Attribute::TEX_COORD, 12);
  draco::EncoderBuffer out;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(mesh, &out).ok());
  return {out.data(), out.size()};
}

std::unique_ptr<draco::Mesh> Decode(const std::string& stream) {
  draco::DecoderBuffer in;
  in.Init(stream.data(), stream.size());
  return draco::Decoder().DecodeMeshFromBuffer(&in).value();
}

// A plane of n x n quads. With `split`, each corner of a triangle is a point of its own.
std::unique_ptr<draco::Mesh> Plane(uint32_t n, bool split = false) {
  auto mesh = std::make_unique<draco::Mesh>();
  std::vector<std::array<uint32_t, 3>> triangles;
  for (uint32_t y = 0; y < n; ++y) {
    for (uint32_t x = 0; x < n; ++x) {
      const uint32_t a = y * (n + 1) + x, b = a + 1, c = a + n + 1, d = c + 1;
      triangles.push_back({a, b, d});
      triangles.push_back({a, d, c});
    }
  }
  const uint32_t vertices = (n + 1) * (n + 1);
  const auto corners = static_cast<uint32_t>(3 * triangles.size());
  mesh->set_num_points(split ? corners : vertices);
  Attribute position;
  position.Init(Attribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false, 12, 0);
  auto* values = mesh->attribute(mesh->AddAttribute(position, !split, vertices));
  for (uint32_t v = 0; v < vertices; ++v) {
    const std::array<float, 3> p{static_cast<float>(v % (n + 1)), static_cast<float>(v / (n + 1)),
                                 0};
    values->SetAttributeValue(draco::AttributeValueIndex(v), p.data());
  }
  uint32_t corner = 0;
  for (const auto& triangle : triangles) {
    draco::Mesh::Face face;
    for (size_t i = 0; i < 3; ++i, ++corner) {
      face[i] = split ? corner : triangle[i];
      if (!split) continue;
      values->SetPointMapEntry(draco::PointIndex(corner), draco::AttributeValueIndex(triangle[i]));
    }
    mesh->AddFace(face);
  }
  return mesh;
}

// Adds attributes of single bytes; each point has a value of its own.
void AddBytes(draco::Mesh& mesh, int attributes, int8_t components, bool vary) {
  for (int a = 0; a < attributes; ++a) {
    Attribute attribute;
    const auto bytes = static_cast<uint8_t>(components);
    attribute.Init(Attribute::GENERIC, nullptr, bytes, draco::DT_UINT8, false, bytes, 0);
    auto* values = mesh.attribute(mesh.AddAttribute(attribute, true, mesh.num_points()));
    std::vector<uint8_t> value(bytes);
    for (uint32_t p = 0; p < mesh.num_points(); ++p) {
      if (vary) value[0] = static_cast<uint8_t>(p);
      values->SetAttributeValue(draco::AttributeValueIndex(p), value.data());
    }
  }
}

// A tree of metadata with short names: `width` trees in each, down to `depth`.
void AddTrees(draco::Metadata& metadata, int width, int depth) {
  for (int i = 0; i < width; ++i) {
    auto tree = std::make_unique<draco::Metadata>();
    if (depth > 1) AddTrees(*tree, width, depth - 1);
    metadata.AddSubMetadata(std::string(1, static_cast<char>(i)), std::move(tree));
  }
}

std::unique_ptr<draco::Mesh> PlaneOfAttributeMetadata() {
  auto mesh = Plane(4);
  auto metadata = std::make_unique<draco::GeometryMetadata>();
  for (uint32_t i = 0; i < 100'000; ++i) {
    auto attribute = std::make_unique<draco::AttributeMetadata>();
    attribute->set_att_unique_id(i % 100);
    metadata->AddAttributeMetadata(std::move(attribute));
  }
  mesh->AddMetadata(std::move(metadata));
  return mesh;
}

std::unique_ptr<draco::Mesh> PlaneOfMetadata() {
  auto mesh = Plane(4);
  auto metadata = std::make_unique<draco::GeometryMetadata>();
  AddTrees(*metadata, 200, 2);
  for (int i = 0; i < 20'000; ++i) metadata->AddEntryInt(fmt::format("{:x}", i), i);
  mesh->AddMetadata(std::move(metadata));
  return mesh;
}

}  // namespace

std::string EdgebreakerStream(const std::string& sequential) {
  return Encode(*Decode(sequential), draco::MESH_EDGEBREAKER_ENCODING);
}

std::vector<std::pair<std::string, std::string>> CrowdedDracoStreams() {
  std::vector<std::pair<std::string, std::string>> streams;
  const auto add = [&streams](const std::string& name, const draco::Mesh& mesh) {
    streams.emplace_back(name + " seq", Encode(mesh, draco::MESH_SEQUENTIAL_ENCODING));
    streams.emplace_back(name + " eb", Encode(mesh, draco::MESH_EDGEBREAKER_ENCODING));
  };
  auto mesh = Plane(100);
  AddBytes(*mesh, 5, 127, false);
  add("components", *mesh);
  mesh = Plane(100);
  AddBytes(*mesh, 60, 1, true);
  add("attributes", *mesh);
  mesh = Plane(8);
  AddBytes(*mesh, 4'000, 1, false);
  streams.emplace_back("objects seq", Encode(*mesh, draco::MESH_SEQUENTIAL_ENCODING));
  mesh = Plane(100, /*split=*/true);
  AddBytes(*mesh, 8, 3, true);
  add("corners", *mesh);
  add("metadata", *PlaneOfMetadata());
  add("by attribute", *PlaneOfAttributeMetadata());
  return streams;
}

}  // namespace latticed::testing
