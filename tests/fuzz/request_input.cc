// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/request_input.h"

#include <google/protobuf/text_format.h>

#include <algorithm>
#include <array>

#include "latticed/v1/mesh.pb.h"
#include "latticed/v1/points.pb.h"
#include "latticed/v1/scene.pb.h"
#include "latticed/v1/server.pb.h"
#include "latticed/v1/share.pb.h"
#include "tests/fuzz/fuzz_call.h"
#include "tests/fuzz/fuzz_server.h"

namespace latticed::fuzz {
namespace {

using google::protobuf::MethodDescriptor;

constexpr size_t kHeadBytes = 3;
constexpr size_t kMostBytes = 0x7fff;
constexpr size_t kMostRecords = 8;  // keeps the time of an input near some milliseconds

// The messages of a call in text form. With `flags` of the last record.
struct TextCall {
  const char* method;
  std::vector<const char*> messages;
  uint16_t flags = 0;
};

constexpr uint16_t kOpen = RequestRecord::kLeaveOpen;

// A triangle as RAW: three positions in float32 and one face.
constexpr char kRawData[] =
    R"(data: "\000\000\000\000\000\000\000\000\000\000\000\000\000\000\200?\000\000\000\000\000\000\000\000\000\000\000\000\000\000\200?\000\000\000\000\000\000\000\000\001\000\000\000\002\000\000\000")";

// A point in the cube and a normal, or cotangents of both.
constexpr char kTwoVectors[] =
    R"(data: "\000\000\000\000\000\000\340?\000\000\000\000\000\000\340?\000\000\000\000\000\000\340?\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\360?")";

const std::vector<TextCall>& TextCalls() {
  static const std::vector<TextCall> calls = {
      {"UploadMesh",
       {R"(header { name: "t" format: MESH_FORMAT_OBJ total_bytes: 33 })",
        R"(data: "v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\n\n")"}},
      {"UploadMesh",
       {R"(header { name: "raw" format: MESH_FORMAT_RAW total_bytes: 48 units { up_axis: UP_AXIS_Z meters_per_unit: 1 }
            raw_layout { vertex_count: 3 face_count: 1 corner_count: 3 face_size: 3
            position_type: SCALAR_TYPE_FLOAT32 group_names: "g" } })",
        kRawData}},
      {"BeginUpload",
       {R"(header { format: MESH_FORMAT_STL total_bytes: 15 labels { key: "k" value: "v" } })"}},
      {"AppendUpload", {R"(upload_id: "@upload" data: "solid\nendsolid\n")"}},
      {"FinishUpload", {R"(upload_id: "@upload")"}},
      {"GetMesh", {R"(mesh: "@mesh")"}},
      {"ListMeshes", {R"(page_size: 1 filter: "k=v")"}},
      {"ListMeshes", {R"(page_token: "@page")"}},
      {"DeleteMesh", {R"(mesh: "@mesh" force: true)"}},
      {"DownloadMesh", {R"(mesh: "@mesh" offset: 3)"}},
      {"CreateScene",
       {R"(scene_id: "second-scene" mesh: "@mesh" lattices { fit { size { u: 4 v: 3 w: 2 }
            degree { u: 2 v: 1 w: 1 } padding: 0.1 } } idle_ttl { seconds: 60 }
            default_view { segments: 3 normals: NORMAL_MODE_SMOOTH encoding: ENCODING_RAW })"}},
      {"CreateScene",
       {R"(scene_id: "second-scene" mesh: "@mesh" lattices { lattice { frame { origin { x: -1 y: -1 z: -1 }
            u { x: 3 } v { y: 3 } w { z: 3 } } degree { u: 1 v: 1 w: 1 } size { u: 2 v: 2 w: 2 }
            knots_u: 0 knots_u: 0 knots_u: 1 knots_u: 1 } } diagnostics { pipeline: PIPELINE_CONTROL_NET })"}},
      {"GetScene", {R"(scene: "scene-one")"}},
      {"ListScenes", {R"(page_size: 1)"}},
      {"ListScenes", {R"(page_token: "@page")"}},
      {"DeleteScene", {R"(scene: "second-scene")"}},
      {"GetLattice", {R"(scene: "scene-one")"}},
      {"ApplyEdits", {R"(scene: "scene-one" editor_id: "editor-one" sequence: 1 structure_id: 1
            edits { set_control_points { indices: 26 positions: 2 positions: 2 positions: 2 } })"}},
      {"ApplyEdits",
       {R"(scene: "scene-one" editor_id: "editor-one" sequence: 2 structure_id: 1 gesture_id: "gesture-one"
            gesture_phase: GESTURE_PHASE_UPDATE edits { move_control_points { indices: 0 offset { x: 0.5 } } })"}},
      {"ApplyEdits", {R"(scene: "scene-one" editor_id: "editor-one" sequence: 3 structure_id: 1
            edits { transform_control_points { indices: 1 matrix: [1,0,0,0, 0,1,0,0, 0,0,1,0, 1,0,0,1] } })"}},
      {"ApplyEdits", {R"(scene: "scene-one" editor_id: "editor-one" sequence: 3 structure_id: 1
            edits { carry_control_points { indices: 2 parent { degree { u: 1 v: 1 w: 1 } size { u: 2 v: 2 w: 2 }
            frame { origin {} u { x: 1 } v { y: 1 } w { z: 1 } } control_points:
            [0,0,0, 1,0,0, 0,1,0, 1,1,0, 0,0,1, 1,0,1, 0,1,1, 1,1,2] } } })"}},
      {"ApplyEdits", {R"(scene: "scene-one" editor_id: "editor-two" sequence: 1 structure_id: 1
            edits { drag_points { points { corners: [0, 1, 3] barycentrics: [0.25, 0.25, 0.5] }
            targets: [1, 1, 1] } })"}},
      {"ApplyEdits", {R"(scene: "scene-one" editor_id: "editor-two" sequence: 2 structure_id: 1
            edits { insert_knot { axis: LATTICE_AXIS_U value: 0.5 } })"}},
      {"ApplyEdits", {R"(scene: "scene-one" editor_id: "editor-two" sequence: 3 structure_id: 2
            edits { replace_lattice { lattice { degree { u: 1 v: 2 w: 3 } size { u: 3 v: 4 w: 5 }
            frame { origin {} u { x: 1 } v { y: 1 } w { z: 1 } } } } })"}},
      {"ApplyEdits", {R"(scene: "scene-one" editor_id: "editor-two" sequence: 4 structure_id: 2
            edits { set_strength { strength: 0.5 } })"}},
      {"ApplyEdits", {R"(scene: "scene-one" editor_id: "editor-two" sequence: 5 structure_id: 2
            edits { set_weights { some { indices: 1 values: "\000\000\000\077" } } })"}},
      {"ApplyEdits", {R"(scene: "scene-one" editor_id: "editor-two" sequence: 6 structure_id: 2
            lattice: 1 edits { remove_lattice {} })"}},
      {"ApplyEdits",
       {R"(scene: "scene-one" editor_id: "editor-one" sequence: 4 edits { undo { scope: UNDO_SCOPE_SCENE } })"}},
      {"ApplyEdits",
       {R"(scene: "scene-one" editor_id: "editor-one" sequence: 5 edits { redo {} })"}},
      {"ApplyEdits", {R"(scene: "scene-one" editor_id: "editor-one" sequence: 6
            edits { reset { target: RESET_TARGET_INITIAL } } edits { replace_control_points {} })"}},
      {"Deform",
       {R"(watch { scene: "scene-one" editor_id: "editor-one" max_unacked_updates: 1
            view { segments: 2 encoding: ENCODING_DRACO_MESH normals: NORMAL_MODE_FACET } })",
        R"(edit { sequence: 1 structure_id: 1 edits { move_control_points { indices: 13 offset { z: 1 } } } })",
        R"(control { acked_update_id: 1 pause: true view { segments: 5 encoding: ENCODING_QUANTISED } })",
        R"(presence { name: "one" colour: 255 selected_indices: 3 following: "editor-two"
            camera { position { y: -5 } target {} up { z: 1 } fov_y: 40 } })",
        R"(heartbeat {})"}},
      {"Deform",
       {R"(watch { scene: "scene-one" editor_id: "editor-one" resume_token: "@resume" })",
        R"(edit { sequence: 7 structure_id: 1 edits { insert_knot { axis: LATTICE_AXIS_W value: 0.25 } } })"},
       kOpen},
      {"Watch",
       {R"(scene: "scene-one" editor_id: "editor-two" view { segments: 4 encoding: ENCODING_RAW })"}},
      {"Watch",
       {R"(scene: "scene-one" editor_id: "editor-two" resume_token: "@resume" view { max_points: 100
            max_bytes_per_second: 1000 drag_position_bits: 8 })"},
       kOpen},
      {"ControlWatch", {R"(watch_id: "@watch" acked_update_id: 1 pause: false view { segments: 6 }
            presence { name: "two" camera { position { z: 5 } target {} up { y: 1 } height: 2.5 } })"}},
      {"GetUpdate",
       {R"(scene: "scene-one" view { encoding: ENCODING_QUANTISED position_bits: 16 normal_bits: 8 })"}},
      {"GetTopology", {R"(scene: "scene-one" topology_id: "@topology")"}},
      {"GetPatchPlan",
       {R"(scene: "scene-one" topology_id: "@topology" normals: NORMAL_MODE_SMOOTH)"}},
      {"GetUpdate", {R"(scene: "scene-one" view { encoding: ENCODING_PATCHES })"}},
      {"Export", {R"(scene: "scene-one" format: EXPORT_FORMAT_GLB view { segments: 2 })"}},
      {"Export",
       {R"(scene: "scene-one" format: EXPORT_FORMAT_DRC view { normals: NORMAL_MODE_SMOOTH })"}},
      {"Export",
       {R"(scene: "scene-one" format: EXPORT_FORMAT_USD geometry: EXPORT_GEOMETRY_ORIGINAL view { normals: NORMAL_MODE_SMOOTH })"}},
      {"Pick", {R"(scene: "scene-one" ray { origin { x: 0.4 y: 0.3 z: 9 } direction { z: -1 } })"}},
      {"EvaluatePoints",
       {R"(scene: "scene-one" surface_points { points { face: 2 corners: [0, 1, 3] barycentrics: [0.2, 0.3, 0.5] } })"}},
      {"EvaluatePoints", {R"(scene: "scene-one" world_points { positions: [0.5, 0.5, 0.5] })"}},
      {"CertifyFolds", {R"(scene: "scene-one" scope: FOLD_SCOPE_VOLUME)"}},
      {"MeasureScene",
       {R"(scene: "scene-one" measures: [MEASURE_VOLUME, MEASURE_AREA] with_gradient: true)"}},
      {"ApplyEdits",
       {R"(scene: "scene-one" editor_id: "editor-one" sequence: 7 structure_id: 1 refuse_folds: true
            edits { set_constraints { constraints { held: 0 held_layers { axis: LATTICE_AXIS_W layers: 1 }
            volume { axis: LATTICE_AXIS_W } } } } keep_volume {})"}},
      {"CreatePointSet",
       {R"(header { scene: "scene-one" world { points: 1 with_normals: true } })", kTwoVectors}},
      {"CreatePointSet",
       {R"(header { scene: "scene-one" surface { points: 1 } })",
        R"(data: "\000\000\000\000\000\000\000\000\001\000\000\000\003\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\360?")"}},
      {"CreatePointSet",
       {R"(header { scene: "scene-one" view { segments: 2 normals: NORMAL_MODE_FACET } })"}},
      {"ListPointSets", {R"(scene: "scene-one")"}},
      {"DeformPointSet", {R"(scene: "scene-one" point_set: "@points" with_normals: true)"}},
      {"ApplyJacobian",
       {R"(scene: "scene-one" point_set: "@points" indices: 1 tangents: "\000\000\000\000\000\000\360?\000\000\000\000\000\000\360?\000\000\000\000\000\000\360?")"}},
      {"ApplyJacobianTranspose",
       {R"(header { scene: "scene-one" point_set: "@points" with_normals: true directions: 1 })",
        kTwoVectors}},
      {"DeletePointSet", {R"(scene: "scene-one" point_set: "@points")"}},
      {"GetServerInfo", {""}},
  };
  return calls;
}

size_t NumberOf(const std::string& name) {
  const auto& methods = Methods();
  const auto method = std::ranges::find(methods, name, [](const auto* m) { return m->name(); });
  if (method == methods.end()) Fail("no rpc is called " + name);
  return static_cast<size_t>(method - methods.begin());
}

}  // namespace

const std::vector<const MethodDescriptor*>& Methods() {
  static const auto* const all = [] {
    auto* const methods = new std::vector<const MethodDescriptor*>;
    for (const auto* file : {v1::Mesh::descriptor()->file(), v1::Scene::descriptor()->file(),
                             v1::ServerInfo::descriptor()->file(), v1::Share::descriptor()->file(),
                             v1::PointSet::descriptor()->file()}) {
      const auto* const service = file->service(0);
      for (int i = 0; i < service->method_count(); ++i) methods->push_back(service->method(i));
    }
    return methods;
  }();
  return *all;
}

const MethodDescriptor* MethodOf(const RequestRecord& record) {
  return Methods()[record.rpc() % Methods().size()];
}

std::vector<RequestRecord> ReadRecords(std::string_view input) {
  std::vector<RequestRecord> records;
  while (input.size() >= kHeadBytes && records.size() < kMostRecords) {
    const auto byte = [input](size_t i) { return static_cast<uint8_t>(input[i]); };
    const size_t length = byte(1) | static_cast<size_t>(byte(2)) << 8;
    const std::string_view bytes = input.substr(kHeadBytes, length & kMostBytes);
    const size_t head = byte(0) | (length & ~kMostBytes) >> 7;
    records.push_back({static_cast<uint16_t>(head), std::string(bytes)});
    input.remove_prefix(kHeadBytes + bytes.size());
  }
  return records;
}

std::string WriteRecords(const std::vector<RequestRecord>& records) {
  std::string input;
  for (const RequestRecord& record : records) {
    const std::string_view bytes = std::string_view(record.bytes).substr(0, kMostBytes);
    const size_t length = bytes.size() | (record.head & 0x100U) << 7;
    input.push_back(static_cast<char>(record.head));
    input.push_back(static_cast<char>(length & 0xff));
    input.push_back(static_cast<char>(length >> 8));
    input.append(bytes);
  }
  return input;
}

const std::vector<std::vector<RequestRecord>>& Templates() {
  static const auto* const all = [] {
    auto* const templates = new std::vector<std::vector<RequestRecord>>;
    for (const TextCall& call : TextCalls()) {
      auto& records = templates->emplace_back();
      const size_t rpc = NumberOf(call.method);
      const auto message = NewMessage(Methods()[rpc]->input_type());
      for (const char* text : call.messages) {
        if (!google::protobuf::TextFormat::ParseFromString(text, message.get())) Fail(text);
        const auto flags = static_cast<uint16_t>(records.empty() ? 0 : RequestRecord::kSameCall);
        records.push_back({static_cast<uint16_t>(RequestRecord::HeadOf(rpc) | flags | kOpen),
                           message->SerializeAsString()});
      }
      records.back().head = static_cast<uint16_t>((records.back().head & ~kOpen) | call.flags);
    }
    return templates;
  }();
  return *all;
}

}  // namespace latticed::fuzz
