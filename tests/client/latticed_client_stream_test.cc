// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The stream against a server that breaks: what it sends when it opens itself again.
#include "client/cpp/library/stream.h"

#include <algorithm>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "client/cpp/library/latticed_client.h"
#include "google/rpc/error_info.pb.h"
#include "tests/client/fake_server.h"
#include "tests/support/status_matchers.h"

namespace latticed::client {
namespace {

using ::latticed::testing::StatusIs;
using Events = grpc::ServerReaderWriter<v1::SceneEvent, v1::DeformRequest>;

// Answers every edit with a result and an empty update, but for the stream numbers in `failures`,
// which end with that status when so many edits came, unanswered. As the server does, it takes an
// edit below the last one for one that is out of order.
class FlakyScenes final : public v1::SceneService::Service {
 public:
  std::map<int, grpc::Status> failures;
  int edits_until_failure = 1;
  std::vector<v1::WatchRequest> opened;
  std::vector<uint64_t> sequences;

  grpc::Status Deform(grpc::ServerContext*, Events* stream) override {
    v1::DeformRequest request;
    stream->Read(&request);
    const std::lock_guard lock(mutex_);
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
  void SendUpdate(uint64_t sequence, Events* stream) {
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

  std::mutex mutex_;
  uint64_t update_id_ = 0, taken_ = 0;
};

class DeformStreamTest : public ::testing::Test {
 protected:
  absl::StatusOr<std::unique_ptr<DeformStream>> Open() {
    v1::WatchRequest watch;
    watch.set_scene("scene-of-this-test");
    return client_->Deform(watch);
  }

  static v1::EditBatch OneEdit() {
    v1::EditBatch batch;
    batch.add_edits()->mutable_redo();
    return batch;
  }

  FlakyScenes service_;
  FakeServer server_{&service_};
  const std::unique_ptr<Client> client_ = Client::Connect({.address = server_.address()});
};

TEST_F(DeformStreamTest, WaitsForTheUpdateThatHoldsTheEdit) {
  const auto stream = Open();
  ASSERT_OK(stream);
  const auto sequence = (*stream)->Send(OneEdit());
  ASSERT_OK(sequence);
  const auto update = (*stream)->WaitFor(*sequence);
  ASSERT_OK(update);
  EXPECT_EQ(update->end.applied_sequence(), 1u);
  EXPECT_EQ((*stream)->reconnections(), 0);
}

TEST_F(DeformStreamTest, ARefusedEditIsItsOwnErrorAndTheStreamGoesOn) {
  const auto stream = Open();
  ASSERT_OK(stream);
  const auto refused = (*stream)->Send({});
  ASSERT_OK(refused);
  EXPECT_THAT((*stream)->WaitFor(*refused),
              StatusIs(absl::StatusCode::kInvalidArgument, "edits: none"));
  const auto sequence = (*stream)->Send(OneEdit());
  ASSERT_OK(sequence);
  EXPECT_OK((*stream)->WaitFor(*sequence));
}

TEST_F(DeformStreamTest, WaitsForEditsInAnyOrder) {
  const auto stream = Open();
  ASSERT_OK(stream);
  const auto first = (*stream)->Send(OneEdit());
  const auto refused = (*stream)->Send({});
  const auto last = (*stream)->Send(OneEdit());
  ASSERT_OK(first);
  ASSERT_OK(refused);
  ASSERT_OK(last);
  EXPECT_OK((*stream)->WaitFor(*last));

  for (int again = 0; again < 2; ++again) {
    const auto update = (*stream)->WaitFor(*first);
    ASSERT_OK(update);
    EXPECT_EQ(update->end.applied_sequence(), *last);
    EXPECT_THAT((*stream)->WaitFor(*refused),
                StatusIs(absl::StatusCode::kInvalidArgument, "edits: none"));
  }
  (*stream)->HalfClose();
  const auto end = (*stream)->Next();
  ASSERT_OK(end);
  EXPECT_TRUE(end->ended());
  EXPECT_OK((*stream)->WaitFor(*first));
  EXPECT_EQ(service_.sequences, (std::vector<uint64_t>{1, 2, 3}));
}

TEST_F(DeformStreamTest, AnEditThatWasNeverSentIsNotWaitedFor) {
  const auto stream = Open();
  ASSERT_OK(stream);
  for (const uint64_t sequence : {0u, 1u}) {
    EXPECT_THAT((*stream)->WaitFor(sequence),
                StatusIs(absl::StatusCode::kInvalidArgument, ::testing::HasSubstr("never sent")));
  }
}

TEST_F(DeformStreamTest, AnotherEditorsEditIsRefusedAndNotSent) {
  const auto stream = Open();
  ASSERT_OK(stream);
  v1::EditBatch batch = OneEdit();
  batch.set_editor_id("another-editor");
  EXPECT_THAT((*stream)->Send(batch),
              StatusIs(absl::StatusCode::kInvalidArgument, ::testing::HasSubstr("another-editor")));

  batch.set_editor_id((*stream)->editor_id());
  const auto sequence = (*stream)->Send(batch);
  ASSERT_OK(sequence);
  EXPECT_OK((*stream)->WaitFor(*sequence));
  EXPECT_EQ(service_.sequences, (std::vector<uint64_t>{1}));
}

TEST_F(DeformStreamTest, ResumesWithItsTokenAndItsUnansweredEdits) {
  for (const auto code : {grpc::StatusCode::CANCELLED, grpc::StatusCode::INTERNAL,
                          grpc::StatusCode::UNAVAILABLE, grpc::StatusCode::UNKNOWN}) {
    service_.failures[static_cast<int>(service_.failures.size()) + 1] =
        grpc::Status(code, "broken");
  }
  const auto stream = Open();
  ASSERT_OK(stream);
  const auto sequence = (*stream)->Send(OneEdit());
  ASSERT_OK(sequence);

  const auto update = (*stream)->WaitFor(*sequence);

  ASSERT_OK(update);
  EXPECT_EQ(update->end.applied_sequence(), 1u);
  EXPECT_EQ((*stream)->reconnections(), 4);
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
  const auto stream = Open();
  ASSERT_OK(stream);
  const auto first = (*stream)->Send(OneEdit()), second = (*stream)->Send(OneEdit());
  ASSERT_OK(first);
  ASSERT_OK(second);

  const auto step = (*stream)->Next();

  ASSERT_OK(step);
  ASSERT_TRUE(step->update.has_value()) << "of the stream that was opened again";
  EXPECT_OK((*stream)->WaitFor(*second));
  EXPECT_OK((*stream)->WaitFor(*first));
  // The answer to the first one tells of both: the second may still be on its way.
  (*stream)->HalfClose();
  auto last = (*stream)->Next();
  while (last.ok() && !last->ended()) last = (*stream)->Next();
  ASSERT_OK(last);
  EXPECT_EQ(service_.sequences, (std::vector<uint64_t>{1, 2, 1, 2}));
}

TEST_F(DeformStreamTest, OtherErrorsEndIt) {
  service_.failures[1] = grpc::Status(grpc::StatusCode::NOT_FOUND, "no scene");
  const auto stream = Open();
  ASSERT_OK(stream);
  const auto sequence = (*stream)->Send(OneEdit());
  ASSERT_OK(sequence);
  EXPECT_THAT((*stream)->WaitFor(*sequence), StatusIs(absl::StatusCode::kNotFound, "no scene"));
}

TEST_F(DeformStreamTest, HalfCloseEndsItAfterTheLastEdit) {
  const auto stream = Open();
  ASSERT_OK(stream);
  const auto sequence = (*stream)->Send(OneEdit());
  ASSERT_OK(sequence);
  (*stream)->HalfClose();
  EXPECT_OK((*stream)->WaitFor(*sequence));
  const auto last = (*stream)->Next();
  ASSERT_OK(last);
  EXPECT_TRUE(last->ended());
  EXPECT_THAT((*stream)->Send(OneEdit()), StatusIs(absl::StatusCode::kFailedPrecondition));
}

TEST(Client, NoServerIsUnavailable) {
  // Port 1 of the loopback: nobody listens there.
  const auto client = Client::Connect({.address = "127.0.0.1:1"});
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
