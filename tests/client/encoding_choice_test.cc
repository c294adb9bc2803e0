// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Which encoding is chosen where nobody has named one: by given rates, at servers that are old or slow, for real scenes.
#include "client/cpp/library/encodings/encoding_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "tests/client/fake_server.h"
#include "tests/client/quiet_server.h"
#include "tests/support/status_matchers.h"

namespace latticed::client {
namespace {

using ::latticed::testing::StatusIs;
using ::testing::AnyOf;
using ::testing::ElementsAre;
using ::testing::StartsWith;

// A server of a line with 100,000 bytes a second.
class SlowLine final : public v1::ServerService::Service {
 public:
  std::vector<v1::Encoding> encodings{v1::ENCODING_DRACO_POINTS, v1::ENCODING_MESHOPT};
  std::vector<uint32_t> probes;

  grpc::Status GetServerInfo(grpc::ServerContext*, const v1::GetServerInfoRequest* request,
                             v1::ServerInfo* info) override {
    probes.push_back(request->probe_bytes());
    std::this_thread::sleep_for(std::chrono::microseconds(10) * request->probe_bytes());
    info->set_probe(std::string(request->probe_bytes(), 'x'));
    for (const v1::Encoding encoding : encodings) info->add_encodings(encoding);
    return grpc::Status::OK;
  }
};

TEST(EncodingChoiceTest, WeighsTheTimeOnTheLineAgainstThatOfDecoding) {
  constexpr DecodeTimes kTimes{.draco = 14e-9, .meshopt = 4e-9};

  const EncodingChoice fast = ChooseEncoding(/*line_rate=*/25e6, kTimes);
  const EncodingChoice slow = ChooseEncoding(/*line_rate=*/16e6, kTimes);

  EXPECT_EQ(fast.encoding, v1::ENCODING_MESHOPT);
  EXPECT_EQ(fast.reason,
            "meshopt's 0.2 bytes more a point take 8.0 ns at 25 MB/s, decoding saves 10.0 ns");
  EXPECT_EQ(slow.encoding, v1::ENCODING_DRACO_POINTS);
  EXPECT_EQ(slow.reason,
            "meshopt's 0.2 bytes more a point take 12.5 ns at 16 MB/s, decoding saves 10.0 ns");
}

TEST(EncodingChoiceTest, DecodeTimesAreMeasuredOnce) {
  const DecodeTimes& times = MeasuredDecodeTimes();
  EXPECT_GT(times.meshopt, 0);
  EXPECT_GT(times.draco, times.meshopt);
  EXPECT_EQ(&MeasuredDecodeTimes(), &times);
}

TEST(EncodingChoiceTest, ASlowLineIsNotKeptBusyByLargeProbes) {
  SlowLine slow;
  const FakeServer server({&slow});
  const auto client = Client::Connect({.address = server.address()});

  const auto choice = ChooseEncoding(*client);

  ASSERT_OK(choice);
  EXPECT_EQ(choice->encoding, v1::ENCODING_DRACO_POINTS) << choice->reason;
  EXPECT_THAT(slow.probes, ElementsAre(0, 0, 8192));
}

TEST(EncodingChoiceTest, AServerWithoutMeshoptIsNotProbed) {
  SlowLine old;
  old.encodings.pop_back();
  const FakeServer server({&old});
  const auto client = Client::Connect({.address = server.address()});

  const auto choice = ChooseEncoding(*client);

  ASSERT_OK(choice);
  EXPECT_EQ(choice->encoding, v1::ENCODING_DRACO_POINTS);
  EXPECT_EQ(choice->reason, "the server has no meshopt");
  EXPECT_THAT(old.probes, ElementsAre(0));
}

class OpenEncodingTest : public ::testing::Test {
 protected:
  // The id of a new scene with this default.
  std::string Scene(v1::Encoding encoding) {
    v1::MeshHeader header;
    header.set_format(v1::MESH_FORMAT_OBJ);
    const auto mesh = client_->UploadMesh("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", header);
    EXPECT_OK(mesh);
    v1::CreateSceneRequest request;
    request.set_mesh(mesh->id());
    request.mutable_default_view()->set_encoding(encoding);
    const auto scene = client_->CreateScene(request);
    EXPECT_OK(scene);
    return scene->id();
  }

  const std::unique_ptr<InProcessServer> server_ = StartServer();
  const std::unique_ptr<Client> client_ = std::make_unique<Client>(server_->channel(), "");
};

TEST_F(OpenEncodingTest, IsChosenUnlessTheViewOrTheSceneNamesOne) {
  v1::ViewOptions open, named, of_scene;
  named.set_encoding(v1::ENCODING_QUANTISED);
  const std::string scene = Scene(v1::ENCODING_UNSPECIFIED);

  EXPECT_THAT(ChooseOpenEncoding(*client_, scene, open).value_or(""),
              StartsWith("meshopt's 0.2 bytes more a point take "));
  EXPECT_EQ(ChooseOpenEncoding(*client_, scene, named).value_or("?"), "");
  EXPECT_EQ(ChooseOpenEncoding(*client_, Scene(v1::ENCODING_RAW), of_scene).value_or("?"), "");
  EXPECT_THAT(ChooseOpenEncoding(*client_, "none", of_scene).status(),
              StatusIs(absl::StatusCode::kNotFound));

  EXPECT_THAT(open.encoding(), AnyOf(v1::ENCODING_DRACO_POINTS, v1::ENCODING_MESHOPT));
  EXPECT_EQ(named.encoding(), v1::ENCODING_QUANTISED);
  EXPECT_EQ(of_scene.encoding(), v1::ENCODING_UNSPECIFIED);
}

}  // namespace
}  // namespace latticed::client
