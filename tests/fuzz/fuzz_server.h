// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The whole server in the process of a fuzzer, without sockets, with small limits. Each input finds the same state: a
// cube and the scene "scene-one" of it. Beside them an honest client keeps a scene that no input can name.
//
// Threads  one
#ifndef LATTICED_TESTS_FUZZ_FUZZ_SERVER_H_
#define LATTICED_TESTS_FUZZ_FUZZ_SERVER_H_

#include <memory>
#include <string>

#include "absl/time/time.h"
#include "server/edge/grpc_server.h"
#include "server/engine/scene.h"
#include "server/rpc/server_env.h"
#include "server/web/generic_call.h"

namespace latticed::fuzz {

// Prints the words and aborts, which libFuzzer reports with the input.
[[noreturn]] void Fail(const std::string& words);

// Options of libFuzzer that suit a server with threads: no search for leaks (see Begin), and no entropic schedule, which
// takes three times as long as the server where each input has thousands of features. Called by LLVMFuzzerInitialize.
void SetOptions(int* argc, char*** argv);

class FuzzServer {
 public:
  static FuzzServer& Get();  // of this process
  ~FuzzServer();
  FuzzServer(const FuzzServer&) = delete;  // its server holds its address
  FuzzServer& operator=(const FuzzServer&) = delete;

  // Before each input. Starts another server where earlier inputs left uploads, which only time removes, and after many
  // inputs. Then the old server may have no reservations left, and the process no leaks: libFuzzer's own search for leaks
  // would run after almost each input, because threads allocate and free at any time.
  void Begin();
  // After each input. Fails unless the honest client is answered. Deletes what the input made, and waits until nobody
  // uses it any more.
  void End();

  const std::string& mesh() const { return mesh_; }  // the cube's id
  const Options& options() const { return env_->options; }
  web::ServerChannel channel() const { return {channel_, env_->peer_key}; }

 private:
  FuzzServer();
  void Start();
  void Stop();
  // Whether the scene is as it was made: nobody has edited, watched or exported it.
  bool SceneIsFresh() const;
  void CheckHonest();
  void CreateScene(const std::string& id, const std::string& mesh);
  std::string Upload(const std::string& obj);

  std::string mesh_, honest_mesh_;
  int inputs_ = 0;
  std::shared_ptr<Scene> scene_;  // that inputs use
  absl::Time scene_used_;
  std::unique_ptr<ServerEnv> env_;
  std::unique_ptr<GrpcServer> server_;  // uses env_
  std::shared_ptr<grpc::Channel> channel_;
};

}  // namespace latticed::fuzz

#endif  // LATTICED_TESTS_FUZZ_FUZZ_SERVER_H_
