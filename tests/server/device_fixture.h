// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A server whose backend is a FakeDeviceBackend, and the calls that need a device.
#ifndef LATTICED_TESTS_SERVER_DEVICE_FIXTURE_H_
#define LATTICED_TESTS_SERVER_DEVICE_FIXTURE_H_

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "latticed/v1/server.grpc.pb.h"
#include "tests/server/fake_device_backend.h"
#include "tests/server/scene_fixture.h"

namespace latticed::testing {

class DeviceFixture : public SceneFixture {
 protected:
  void StartOnDevice(uint64_t device_bytes, Options options = {}) {
    auto backend = std::make_unique<FakeDeviceBackend>(device_bytes);
    backend_ = backend.get();
    StartServerOn(std::move(backend), std::move(options));
  }

  // All chunks into `bytes`, in order, where given.
  absl::Status Update(int segments, const std::string& scene = "scene-one",
                      std::vector<std::string>* bytes = nullptr) {
    v1::GetUpdateRequest request;
    request.set_scene(scene);
    request.mutable_view()->set_segments(segments);
    grpc::ClientContext context;
    std::vector<v1::SceneEvent> events;
    auto status = ReadAll(*stub_->GetUpdate(&context, request), events);
    for (const v1::SceneEvent& event : events) {
      for (const auto& chunk : event.chunks().chunks()) {
        if (bytes == nullptr) continue;
        bytes->resize(std::max<size_t>(bytes->size(), chunk.index() + size_t{1}));
        (*bytes)[chunk.index()] = chunk.data();
      }
    }
    return status;
  }

  absl::Status Export(const std::string& scene = "scene-one") {
    v1::ExportRequest request;
    request.set_scene(scene);
    request.set_format(v1::EXPORT_FORMAT_PLY);
    grpc::ClientContext context;
    std::vector<v1::ExportResponse> parts;
    return ReadAll(*stub_->Export(&context, request), parts);
  }

  FakeDeviceBackend* backend_ = nullptr;  // the server's
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_DEVICE_FIXTURE_H_
