// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A Deform stream against a faulty server: what the client sends when it opens the stream again.
#include "client/cpp/library/stream.h"

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "client/cpp/library/latticed_client.h"
#include "client/cpp/library/retries/attempts.h"
#include "core/base/mutex.h"
#include "google/rpc/error_info.pb.h"
#include "tests/client/fake_server.h"
#include "tests/support/status_matchers.h"

namespace latticed::client {
namespace {

using ::latticed::testing::StatusIs;
using Events = grpc::ServerReaderWriter<v1::SceneEvent, v1::DeformRequest>;

// Answers every edit with a result and an empty update. Stream number n in `failures` ends with that
// status after `edits_until_failure` unanswered edits. Like the real server, it refuses an edit as out of
// order if its sequence is below an earlier one.
class FlakyScenes final : public v1::SceneService::Service {
 public:
  std::map<int, grpc::Status> failures;
  int edits_until_failure = 1;
  std::vector<v1::WatchRequest> opened;
  std::vector<uint64_t> sequences;

  grpc::Status Deform(grpc::ServerContext*, Events* stream) override {
    v1::DeformRequest request;
    stream->Read(&request);
    const MutexLock lock(&mutex_);
    opened.push_back(request.watch());
    const int number = static_cast<int>(opened.size());
    SendUpdate(0, stream);
    int edits = 0;
    while (stream->Read(&request)) {
      if (!request.has_edit()) continue;
      const uint64_t sequence = request.edit().sequence();
      sequences.push_back(sequence);
      const bool late = sequence < taken_;
      taken_ = std::max(taken_, sequence);
      if (failures.contains(number)) {
        if (++edits < edits_until_failure) continue;
        return failures[number];
      }
      v1::SceneEvent result;
      result.mutable_edit_result()->set_sequence(sequence);
      if (late) SetOutOfOrder(*result.mutable_edit_result()->mutable_status());
      if (request.edit().edits_size() == 0) {
        result.mutable_edit_result()->mutable_status()->set_code(3);
        result.mutable_edit_result()->mutable_status()->set_message("edits: none");
      }
      stream->Write(result);
      SendUpdate(taken_, stream);
    }
    return grpc::Status::OK;
  }

 private:
  void SendUpdate(uint64_t sequence, Events* stream) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    v1::SceneEvent begin, end;
    begin.mutable_update_begin()->set_update_id(++update_id_);
    stream->Write(begin);
    end.mutable_update_end()->set_update_id(update_id_);
    end.mutable_update_end()->set_applied_sequence(sequence);
    end.mutable_update_end()->set_resume_token("token " + std::to_string(update_id_));
    stream->Write(end);
  }

  static void SetOutOfOrder(google::rpc::Status& status) {
    status.set_code(grpc::StatusCode::ABORTED);
    google::rpc::ErrorInfo info;
    info.set_domain("latticed");
    info.set_reason("OUT_OF_ORDER");
    status.add_details()->PackFrom(info);
  }

  Mutex mutex_;
  uint64_t update_id_ ABSL_GUARDED_BY(mutex_) = 0, taken_ ABSL_GUARDED_BY(mutex_) = 0;
};

class DeformStreamTest : public ::testing::Test {
 protected:
  void Open() {
    v1::WatchRequest watch;
    watch.set_scene("scene-of-this-test");
    auto stream = client_->Deform(watch);
    ASSERT_OK(stream);
    stream_ = *std::move(stream);
  }
  // Sends an edit and returns its sequence.
  uint64_t Send(const v1::EditBatch& batch = OneEdit()) {
    const auto sequence = stream_->Send(batch);
    EXPECT_OK(sequence);
    return sequence.value_or(0);
  }

  static v1::EditBatch OneEdit() {
    v1::EditBatch batch;
    batch.add_edits()->mutable_redo();
    return batch;
  }

  FlakyScenes service_;
  FakeServer server_{&service_};
  const std::unique_ptr<Client> client_ = Client::Connect({.address = server_.address()});
  std::unique_ptr<DeformStream> stream_;
};

TEST_F(DeformStreamTest, ARefusedEditIsItsOwnErrorAndTheStreamGoesOn) {
  ASSERT_NO_FATAL_FAILURE(Open());
  const uint64_t refused = Send({});
  EXPECT_THAT(stream_->WaitFor(refused),
              StatusIs(absl::StatusCode::kInvalidArgument, "edits: none"));
  const uint64_t sequence = Send();
  EXPECT_OK(stream_->WaitFor(sequence));
}

TEST_F(DeformStreamTest, WaitsForEditsInAnyOrder) {
  ASSERT_NO_FATAL_FAILURE(Open());
  const uint64_t first = Send(), refused = Send({}), last = Send();
  EXPECT_OK(stream_->WaitFor(last));

  for (int again = 0; again < 2; ++again) {
    const auto update = stream_->WaitFor(first);
    ASSERT_OK(update);
    EXPECT_EQ(update->end.applied_sequence(), last);
    EXPECT_THAT(stream_->WaitFor(refused),
                StatusIs(absl::StatusCode::kInvalidArgument, "edits: none"));
  }
  stream_->HalfClose();
  const auto end = stream_->Next();
  ASSERT_OK(end);
  EXPECT_TRUE(end->ended());
  EXPECT_OK(stream_->WaitFor(first));
  EXPECT_EQ(service_.sequences, (std::vector<uint64_t>{1, 2, 3}));
}

TEST_F(DeformStreamTest, AnEditThatWasNeverSentIsNotWaitedFor) {
  ASSERT_NO_FATAL_FAILURE(Open());
  for (const uint64_t sequence : {0u, 1u}) {
    EXPECT_THAT(stream_->WaitFor(sequence),
                StatusIs(absl::StatusCode::kInvalidArgument, ::testing::HasSubstr("never sent")));
  }
}

TEST_F(DeformStreamTest, AnotherEditorsEditIsRefusedAndNotSent) {
  ASSERT_NO_FATAL_FAILURE(Open());
  v1::EditBatch batch = OneEdit();
  batch.set_editor_id("another-editor");
  EXPECT_THAT(stream_->Send(batch),
              StatusIs(absl::StatusCode::kInvalidArgument, ::testing::HasSubstr("another-editor")));

  batch.set_editor_id(stream_->editor_id());
  const uint64_t sequence = Send(batch);
  EXPECT_OK(stream_->WaitFor(sequence));
  EXPECT_EQ(service_.sequences, (std::vector<uint64_t>{1}));
}

TEST_F(DeformStreamTest, ResumesWithItsTokenAndItsUnansweredEdits) {
  for (const auto code : {grpc::StatusCode::CANCELLED, grpc::StatusCode::INTERNAL,
                          grpc::StatusCode::UNAVAILABLE, grpc::StatusCode::UNKNOWN}) {
    service_.failures[static_cast<int>(service_.failures.size()) + 1] =
        grpc::Status(code, "broken");
  }
  ASSERT_NO_FATAL_FAILURE(Open());
  const uint64_t sequence = Send();

  const auto update = stream_->WaitFor(sequence);

  ASSERT_OK(update);
  EXPECT_EQ(update->end.applied_sequence(), 1u);
  EXPECT_EQ(stream_->reconnections(), 4);
  EXPECT_EQ(service_.sequences, (std::vector<uint64_t>{1, 1, 1, 1, 1}));
  ASSERT_EQ(service_.opened.size(), 5u);
  EXPECT_EQ(service_.opened[0].resume_token(), "");
  EXPECT_EQ(service_.opened[1].resume_token(), "token 1");
  EXPECT_EQ(service_.opened[4].resume_token(), "token 4");
  EXPECT_EQ(service_.opened[4].editor_id(), service_.opened[0].editor_id());
}

TEST_F(DeformStreamTest, EditsWhoseAnswersWereLostAreNotRefused) {
  service_.failures[1] = grpc::Status(grpc::StatusCode::UNAVAILABLE, "broken");
  service_.edits_until_failure = 2;
  ASSERT_NO_FATAL_FAILURE(Open());
  const uint64_t first = Send(), second = Send();

  const auto step = stream_->Next();

  ASSERT_OK(step);
  ASSERT_TRUE(step->update.has_value()) << "of the stream that was opened again";
  EXPECT_OK(stream_->WaitFor(second));
  EXPECT_OK(stream_->WaitFor(first));
  // The update after the first edit covers both edits: the second may still be on its way.
  stream_->HalfClose();
  auto last = stream_->Next();
  while (last.ok() && !last->ended()) last = stream_->Next();
  ASSERT_OK(last);
  EXPECT_EQ(service_.sequences, (std::vector<uint64_t>{1, 2, 1, 2}));
}

TEST_F(DeformStreamTest, OtherErrorsEndIt) {
  service_.failures[1] = grpc::Status(grpc::StatusCode::NOT_FOUND, "no scene");
  ASSERT_NO_FATAL_FAILURE(Open());
  const uint64_t sequence = Send();
  EXPECT_THAT(stream_->WaitFor(sequence), StatusIs(absl::StatusCode::kNotFound, "no scene"));
}

TEST_F(DeformStreamTest, HalfCloseEndsItAfterTheLastEdit) {
  ASSERT_NO_FATAL_FAILURE(Open());
  const uint64_t sequence = Send();
  stream_->HalfClose();
  EXPECT_OK(stream_->WaitFor(sequence));
  const auto last = stream_->Next();
  ASSERT_OK(last);
  EXPECT_TRUE(last->ended());
  EXPECT_THAT(stream_->Send(OneEdit()), StatusIs(absl::StatusCode::kFailedPrecondition));
}

// Ends each stream with a goaway that has an error. When the client has half-closed, the call ends as a proxy ends it.
class EndingScenes final : public v1::SceneService::Service {
 public:
  int opened = 0;

  grpc::Status Deform(grpc::ServerContext*, Events* stream) override {
    ++opened;
    v1::DeformRequest request;
    stream->Read(&request);
    v1::SceneEvent event;
    auto& status = *event.mutable_goaway()->mutable_status();
    status.set_code(grpc::StatusCode::NOT_FOUND);
    status.set_message("it is gone");
    stream->Write(event);
    while (stream->Read(&request)) continue;
    return {grpc::StatusCode::CANCELLED, "replaced by a proxy"};
  }
};

TEST(Client, TakesTheErrorOfAGoawayForThatOfTheStream) {
  EndingScenes service;
  const FakeServer server({&service});
  const auto client = Client::Connect({.address = server.address()});
  v1::WatchRequest watch;
  watch.set_scene("a-scene");
  EXPECT_THAT(client->Deform(watch), StatusIs(absl::StatusCode::kNotFound, "it is gone"));
  EXPECT_EQ(service.opened, 1);
}

// Refuses calls as UNAVAILABLE: all deletions, and reads before the given one.
class BusyScenes final : public v1::SceneService::Service {
 public:
  int reads = 0, deletions = 0, busy_until = 1'000'000;

  grpc::Status GetScene(grpc::ServerContext*, const v1::GetSceneRequest*, v1::Scene*) override {
    return ++reads < busy_until ? Busy() : grpc::Status::OK;
  }
  grpc::Status DeleteScene(grpc::ServerContext*, const v1::DeleteSceneRequest*,
                           v1::DeleteSceneResponse*) override {
    ++deletions;
    return Busy();
  }

 private:
  static grpc::Status Busy() { return {grpc::StatusCode::UNAVAILABLE, "busy"}; }
};

// The pauses are 75 to 125 ms, 150 to 250, 300 to 500, 600 to 1000, and then at least 750 ms: there are five or six calls,
// and fewer where the machine stalls in one.
TEST(Client, MakesACallAgainForAsLongAsItWasToldAndADeletionOnce) {
  BusyScenes service;
  const FakeServer server({&service});
  std::vector<absl::Status> told;
  const auto client = Client::Connect({.address = server.address(),
                                       .retry_for = absl::Seconds(2),
                                       .observer = [&](auto& s) { told.push_back(s); }});
  EXPECT_THAT(client->GetScene("a-scene"), StatusIs(absl::StatusCode::kUnavailable, "busy"));
  EXPECT_THAT(client->DeleteScene("a-scene"), StatusIs(absl::StatusCode::kUnavailable, "busy"));
  EXPECT_GE(service.reads, 2);
  EXPECT_LE(service.reads, 6);
  EXPECT_EQ(service.deletions, 1);
  ASSERT_EQ(told.size(), 1u) << "once, that it waits";
  EXPECT_THAT(told[0], StatusIs(absl::StatusCode::kUnavailable, "busy"));
}

TEST(Client, SaysThatItWaitsAndThatTheServerAnswersAgain) {
  BusyScenes service;
  const FakeServer server({&service});
  std::vector<absl::StatusCode> told;
  const auto client = Client::Connect(
      {.address = server.address(), .observer = [&](auto& s) { told.push_back(s.code()); }});
  service.busy_until = 2;
  EXPECT_OK(client->GetScene("a-scene"));
  EXPECT_THAT(told, ::testing::IsEmpty()) << "one failure is not worth a word";
  service.busy_until = 6;
  EXPECT_OK(client->GetScene("a-scene"));
  EXPECT_THAT(told, ::testing::ElementsAre(absl::StatusCode::kUnavailable, absl::StatusCode::kOk));
}

TEST(Client, PausesAtMostASecondAndAQuarter) {
  Reachability server(absl::Seconds(30), {});
  Attempts attempts(&server);
  std::vector<absl::Duration> pauses;
  for (int failure = 1; failure <= 100; ++failure) {
    const auto pause = attempts.PauseAfter(absl::UnavailableError("busy"));
    ASSERT_TRUE(pause.has_value());
    const absl::Duration mean =
        std::min(absl::Milliseconds(100) * (1 << std::min(failure - 1, 10)), absl::Seconds(1));
    EXPECT_GE(*pause, 0.75 * mean);
    EXPECT_LE(*pause, 1.25 * mean);
    if (mean == absl::Seconds(1)) pauses.push_back(*pause);
  }
  const auto [least, most] = std::minmax_element(pauses.begin(), pauses.end());
  EXPECT_GT(*most - *least, absl::Milliseconds(250)) << "clients would come back all at once";
}

TEST(Client, NoServerIsUnavailable) {
  // No server listens on loopback port 1.
  const auto client =
      Client::Connect({.address = "127.0.0.1:1", .retry_for = absl::ZeroDuration()});
  EXPECT_THAT(client->GetServerInfo(), StatusIs(absl::StatusCode::kUnavailable));
}

TEST(Client, RandomIdsAreOfTheProtocolsForm) {
  EXPECT_THAT(RandomSceneId(), ::testing::MatchesRegex("[0-9a-f]{32}"));
  EXPECT_THAT(RandomEditorId(),
              ::testing::MatchesRegex(
                  "[0-9a-f]{8}-[0-9a-f]{4}-4[0-9a-f]{3}-[89ab][0-9a-f]{3}-[0-9a-f]{12}"));
  EXPECT_NE(RandomEditorId(), RandomEditorId());
}

}  // namespace
}  // namespace latticed::client
