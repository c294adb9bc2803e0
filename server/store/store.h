// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What outlives the server: meshes, scenes, the log of each scene's edits, and the shares of scenes.
//
// A scene is a header, which never changes, and records 1, 2, 3, … that are appended to it. A record's number is its
// lsn. A snapshot stands for all records up to its own lsn, and the store may then forget those. The store does not read
// headers, records and snapshots (scene_codec.h makes them), but it notices when one was damaged.
//
//   record     Append returns at once. Its `done` is called when the record survives a crash of the machine
//   the rest   is durable when the call returns OK
//
// A record that could not be written breaks its scene: this Append and all later ones are refused until ReadScene
// has told its caller what is stored. The next lsn is then the one after what ReadScene returned. A record that was
// refused is not stored, with two exceptions: of one that is answered kAborted only ReadScene tells; and if the machine
// crashes before the store accepts another write, the next ReadScene may find it.
//
// Several servers may share a store. A scene then belongs to one server at a time: who creates a scene owns it, and who
// wants another one claims it. A server keeps its scenes by a lease, which its store renews; servers that lose it are
// fenced: nothing that they append is written any more. DeleteScene, ReadScene, Append and PutSnapshot need ownership. The
// only server of a store owns all scenes.
//
// Errors   kNotFound, kAlreadyExists; kDataLoss naming what is damaged; kResourceExhausted, reason STORE, where the disk is
//          full or too much waits; kUnavailable, reason STORE, for every other failure of the medium;
//          kFailedPrecondition where a record is not the next; kAborted, reason STORE, where this server does not own
//          the scene, or not any more, or where the store does not know whether a record is stored
// Threads  safe
#ifndef LATTICED_SERVER_STORE_STORE_H_
#define LATTICED_SERVER_STORE_STORE_H_

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "server/base/store_counts.h"

namespace latticed {

// Something that is kept by its id, and its description.
struct StoredEntry {
  std::string id;
  std::string header;
  absl::Status damage;    // kDataLoss: the header is damaged, and left out here
  absl::Duration unused;  // for how long no server has had the scene, where servers share the store
};

// What a scene's next life begins with.
struct SceneLog {
  std::string header;
  uint64_t snapshot_lsn = 0;  // 0: there is no snapshot
  std::string snapshot;
  std::vector<std::string> records;  // from snapshot_lsn + 1 on

  uint64_t lsn() const { return snapshot_lsn + records.size(); }
};

struct SceneClaim {
  std::string
      owner;  // empty: this server owns the scene now; else the name that its owner advertises
};

// A server that uses the store, and whose lease is good.
struct StoredServer {
  std::string name;
  uint64_t free_bytes = 0;  // of its memory, as it said last
};

class Store {
 public:
  using Done = std::function<void(const absl::Status&)>;

  virtual ~Store() = default;

  // kAlreadyExists.
  [[nodiscard]] virtual absl::Status CreateScene(std::string_view id, std::string header) = 0;
  // A scene whose log begins with a snapshot of records 1 to `lsn`, which is at least 1; the store never had them.
  // kAlreadyExists.
  [[nodiscard]] virtual absl::Status CreateSceneAt(std::string_view id, std::string header,
                                                   uint64_t lsn, std::string snapshot) = 0;
  // With its log. kNotFound.
  [[nodiscard]] virtual absl::Status DeleteScene(std::string_view id) = 0;
  // In order of id.
  [[nodiscard]] virtual absl::StatusOr<std::vector<StoredEntry>> Scenes() = 0;
  // Of any scene, whoever owns it. kNotFound, kDataLoss.
  [[nodiscard]] virtual absl::StatusOr<std::string> ReadSceneHeader(std::string_view id) = 0;
  // Waits for the appends under way. kNotFound, kDataLoss.
  [[nodiscard]] virtual absl::StatusOr<SceneLog> ReadScene(std::string_view id) = 0;
  // What is durable of any scene, whoever owns it and appends to it meanwhile. Unlike ReadScene it changes nothing, so a
  // broken scene stays broken. kNotFound, kDataLoss.
  [[nodiscard]] virtual absl::StatusOr<SceneLog> CopyScene(std::string_view id) = 0;
  // Appends record `lsn`, which is one more than the last. Calls `done` once, on a thread of the store and with none of
  // its locks held, in the order of the calls for one scene. `done` may call Append, PutSnapshot and Admit; the other
  // functions wait for the thread that it is on. Without a record (lsn 0, empty) nothing is written, and `done` is
  // called in its turn: after all that was appended to the scene before.
  virtual void Append(std::string_view scene, uint64_t lsn, std::string record, Done done) = 0;
  // OK if more may be appended now. Else the refusal of an edit, with a time to try again: kResourceExhausted while too
  // much waits to be written, and what the medium answered last for as long as it refuses writes.
  [[nodiscard]] virtual absl::Status Admit() = 0;
  // Replaces the scene's snapshot, later and in its turn after what was appended before. A failure is logged and changes
  // nothing.
  virtual void PutSnapshot(std::string_view scene, uint64_t lsn, std::string snapshot) = 0;
  // Waits until all that was appended is answered, and the callbacks are destroyed.
  virtual void Flush() = 0;

  // Makes this server the owner, where nobody is: when this returns, nothing more of the scene's last owner is written.
  // May wait for a lease that runs out. Call ReadScene then, before Append. kNotFound.
  [[nodiscard]] virtual absl::StatusOr<SceneClaim> ClaimScene(std::string_view id);
  // After all appends under way: another server may claim the scene at once. OK as well if it is not this server's.
  [[nodiscard]] virtual absl::Status ReleaseScene(std::string_view id);
  // Deletes a scene of a shared store that no server has had for `unused`. OK as well if one has it, or there is none.
  [[nodiscard]] virtual absl::Status ExpireScene(std::string_view id, absl::Duration unused);
  // `fenced` is called on a thread of the store when this server's lease was lost, and it has a new one: it owns no
  // scene then, and may claim. Set it before the first call of another function. It must not wait, for the store least of
  // all: the lease is not renewed meanwhile.
  virtual void OnFenced(std::function<void()> fenced);
  // Whether several servers may use the store: there may be scenes and meshes that this server has not heard of.
  [[nodiscard]] virtual bool shared() const { return false; }
  // In order of name, this one too. Empty if the store is not shared.
  [[nodiscard]] virtual absl::StatusOr<std::vector<StoredServer>> Servers();
  // What the other servers are told of this one's memory, with the next renewal of the lease.
  virtual void SetFreeBytes(uint64_t bytes);

  // `id` is the SHA-256 of `bytes`, in hex. The same mesh again keeps what there is.
  [[nodiscard]] virtual absl::Status PutMesh(std::string_view id, std::string header,
                                             std::string_view bytes) = 0;
  // kNotFound.
  [[nodiscard]] virtual absl::Status DeleteMesh(std::string_view id) = 0;
  // In order of id.
  [[nodiscard]] virtual absl::StatusOr<std::vector<StoredEntry>> Meshes() = 0;
  // kNotFound, kDataLoss.
  [[nodiscard]] virtual absl::StatusOr<std::string> ReadMeshHeader(std::string_view id) = 0;
  // kNotFound; kDataLoss if the bytes do not have that hash.
  [[nodiscard]] virtual absl::StatusOr<std::string> ReadMesh(std::string_view id) = 0;

  // A share of a scene, which is deleted with it. The same id again replaces the header. kNotFound: there is no such scene.
  [[nodiscard]] virtual absl::Status PutShare(std::string_view id, std::string_view scene,
                                              std::string header) = 0;
  // OK as well if there is none.
  [[nodiscard]] virtual absl::Status DeleteShare(std::string_view id) = 0;
  // Of all scenes, in order of id.
  [[nodiscard]] virtual absl::StatusOr<std::vector<StoredEntry>> Shares() = 0;
  // Another one after each change of what Shares returns. Empty: the store does not know.
  [[nodiscard]] virtual absl::StatusOr<std::string> SharesMark() { return ""; }

  // What it has done so far.
  const StoreCounts& counts() const { return counts_; }

 protected:
  StoreCounts counts_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_STORE_H_
