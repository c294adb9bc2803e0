// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A server on a fake device.
#ifndef LATTICED_TESTS_SERVER_DEVICES_DEVICE_FIXTURE_H_
#define LATTICED_TESTS_SERVER_DEVICES_DEVICE_FIXTURE_H_

#include <map>
#include <memory>
#include <string>
#include <utility>

#include "tests/server/support/scripted_backend.h"
#include "tests/server/support/server_test.h"

namespace latticed::testing {

class DeviceFixture : public SceneFixture {
 protected:
  using Chunks = std::map<uint32_t, std::string>;

  // Starts the server and uploads the mesh `obj`.
  void StartOnDevice(uint64_t device_bytes, const std::string& obj, Options options = {}) {
    auto backend = std::make_unique<ScriptedBackend>(device_bytes);
    backend_ = backend.get();
    StartServerOn(std::move(backend), std::move(options));
    mesh_ = Upload(obj);
  }
  bool OnDevice(const std::string& scene) { return Get(scene).bytes().contains("device_plan"); }

  ScriptedBackend* backend_ = nullptr;  // the server's backend
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_DEVICES_DEVICE_FIXTURE_H_
