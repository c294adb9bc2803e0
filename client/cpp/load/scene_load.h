// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The load on one scene: its editors and watchers, and their logs.
//
//   Open -> WarmUp -> Start -> WaitUntilDone -> Settle -> Close -> Verify -> AddTo(report)
//
// Errors   the server's; kDeadlineExceeded for a stream that stands still (UpdateLog::WaitFor)
// Threads  one at a time
#ifndef LATTICED_CLIENT_CPP_LOAD_SCENE_LOAD_H_
#define LATTICED_CLIENT_CPP_LOAD_SCENE_LOAD_H_

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cpp/latticectl/files.h"
#include "client/cpp/load/load_editor.h"
#include "client/cpp/load/load_report.h"
#include "client/cpp/load/load_watcher.h"
#include "client/cpp/load/surface_verifier.h"

namespace latticed::client {

struct LoadScene {
  std::string id;
  std::shared_ptr<const MeshFile> mesh;  // the mesh that it was made from
};

class SceneLoad {
 public:
  // Makes a client with a connection of its own.
  using NewClient = std::function<std::unique_ptr<Client>()>;

  SceneLoad(const LoadPlan* plan, LoadScene scene, NewClient new_client, LoadControl* control);
  SceneLoad(const SceneLoad&) = delete;  // its editors use it
  SceneLoad& operator=(const SceneLoad&) = delete;

  [[nodiscard]] absl::Status Open();
  // Makes a few edits that are not measured, and waits until all streams that keep up have seen
  // each.
  [[nodiscard]] absl::Status WarmUp();
  void Start(absl::Time begin);
  void WaitUntilDone();
  // Waits until all streams that keep up have the last revision.
  [[nodiscard]] absl::Status Settle();
  void Close();
  // Verifies a few chunks of the last revision of each stream that keeps up, a few measured updates
  // of each stream, and the last update of streams that do not keep up. `fused`: the scene's
  // pipeline. Edits the scene.
  [[nodiscard]] absl::Status Verify(bool fused);
  void AddTo(LoadReport* report) const;

 private:
  absl::Status OpenEditors();
  absl::Status OpenWatchers(int count, const LoadWatcher::Options& options);
  absl::Status WaitForAll(uint64_t revision) const;
  std::vector<SampledUpdate> Samples() const;
  absl::Status VerifySamples(SurfaceVerifier& verifier) const;
  v1::WatchRequest Request() const;

  const LoadPlan& plan_;
  const std::string scene_;
  const std::shared_ptr<const MeshFile> mesh_;
  const NewClient new_client_;
  LoadControl* const control_;
  const std::unique_ptr<Client> client_;  // for unary calls
  v1::LatticeState lattice_;
  uint64_t first_revision_ = 0;  // before the measured edits
  std::vector<AppliedEdit> warm_up_;
  EditLog edits_;
  VerifiedPoints verified_;
  std::vector<std::unique_ptr<LoadWatcher>> watchers_;
  std::vector<std::unique_ptr<LoadEditor>> editors_;  // last: they use all
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_SCENE_LOAD_H_
