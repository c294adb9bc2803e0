// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/scene/scene_replay.h"

#include <algorithm>
#include <utility>

#include "core/base/status_macros.h"
#include "core/ffd/edit/lattice_edit.h"
#include "fmt/format.h"
#include "server/store/records/header_codec.h"
#include "server/store/records/scene_codec.h"
#include "server/store/store_errors.h"

namespace latticed {
namespace {

absl::Status Damaged(uint64_t lsn, const absl::Status& why) {
  return error::Damaged(fmt::format("record {}", lsn), std::string(why.message()));
}

absl::StatusOr<SceneLife> FromSnapshot(const SceneLog& log) {
  LATTICED_ASSIGN_OR_RETURN(auto image, DecodeImage(log.snapshot));
  LATTICED_ASSIGN_OR_RETURN(auto history, SceneHistory::FromImages(std::move(image.histories)));
  if (history.records() != log.snapshot_lsn) {
    return absl::DataLossError(fmt::format("the snapshot of record {} is of record {}",
                                           log.snapshot_lsn, history.records()));
  }
  return SceneLife{std::move(history), image.box, image.now, image.commit_time};
}

// Which control points have moved from their `places`, which become the lattice's.
std::vector<uint32_t> TakeMoved(const Lattice& lattice, std::vector<Vec3d>& places) {
  std::vector<uint32_t> moved;
  for (uint32_t i = 0; i < places.size(); ++i) {
    if (SameBits(lattice.control_points[i], places[i])) continue;
    places[i] = lattice.control_points[i];
    moved.push_back(i);
  }
  return moved;
}

}  // namespace

absl::StatusOr<SceneLife> Replay(const SceneLog& log, const ReplayedMesh& mesh) {
  LATTICED_ASSIGN_OR_RETURN(auto header, DecodeHeader(log.header));
  SceneLife life{.history = SceneHistory(std::move(header.lattices), header.strength),
                 .commit_time = header.create_time};
  if (log.snapshot_lsn > 0) {
    LATTICED_ASSIGN_OR_RETURN(life, FromSnapshot(log));
  }
  if (mesh.vertices > 0) {
    LATTICED_RETURN_IF_ERROR(life.history.MadeWith(mesh.weights, mesh.vertices));
  }
  std::vector<Vec3d> places = life.history.first().lattice().control_points;
  life.moved = PointRevisions(places.size(), life.history.revision());
  CommitTimes commits = {{life.history.revision(), life.commit_time}};
  for (size_t n = 0; n < log.records.size(); ++n) {
    const uint64_t lsn = log.snapshot_lsn + n + 1;
    const uint64_t structure = life.history.structure_id(), revision = life.history.revision();
    const double strength = life.history.first().strength();
    const auto record = DecodeRecord(log.records[n]);
    if (!record.ok()) return Damaged(lsn, record.status());
    if (const auto status = life.history.ApplyRecord(record->edit); !status.ok()) {
      return Damaged(lsn, status);
    }
    const EditHistory& first = life.history.first();
    const Lattice& lattice = first.lattice();
    if (life.history.structure_id() != structure || life.history.size() > 1) {
      places = lattice.control_points;
      life.moved = PointRevisions(places.size(), life.history.revision());
    } else if (first.strength() != strength) {
      places = lattice.control_points;
      life.moved.MoveAll(life.history.revision());
    } else {
      life.moved.Move(TakeMoved(lattice, places), life.history.revision());
    }
    if (record->box.has_value()) life.box = record->box;
    life.now = record->edit.now;
    life.commit_time = record->commit_time;
    if (life.history.revision() > revision) {
      commits.emplace_back(life.history.revision(), record->commit_time);
    }
  }
  const size_t kept = std::min(commits.size(), kMostCommitTimes);
  life.commits.assign(commits.end() - static_cast<ptrdiff_t>(kept), commits.end());
  life.replayed = log.records.size();
  return life;
}

}  // namespace latticed
