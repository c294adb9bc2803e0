// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Which encoding of points suits a line and this machine, where nobody has chosen one (client/README.md, "Encodings").
// Streams take the view as it is: a program asks for the choice, and sets it.
//
//   auto choice = ChooseEncoding(client);             // choice->encoding, and choice->reason for people
//   ChooseOpenEncoding(client, scene, view);          // sets the view's, if it is open
//
// Errors   those of GetServerInfo and GetScene
// Threads  pure but for their calls
#ifndef LATTICED_CLIENT_CPP_LIBRARY_ENCODINGS_ENCODING_CHOICE_H_
#define LATTICED_CLIENT_CPP_LIBRARY_ENCODINGS_ENCODING_CHOICE_H_

#include <string>

#include "absl/status/statusor.h"
#include "client/cpp/library/encodings/decode_times.h"
#include "client/cpp/library/latticed_client.h"
#include "latticed/v1/view.pb.h"

namespace latticed::client {

struct EncodingChoice {
  v1::Encoding encoding = v1::ENCODING_DRACO_POINTS;  // or MESHOPT
  std::string reason;                                 // for people
};

// `line_rate`: bytes a second. One thread decodes.
[[nodiscard]] EncodingChoice ChooseEncoding(double line_rate, const DecodeTimes& times);
// By the rates that it measures. It takes five calls and 520 KiB, on a slow line three and 8 KiB.
[[nodiscard]] absl::StatusOr<EncodingChoice> ChooseEncoding(Client& client);
// Sets the encoding of a view of a scene that names none, unless the scene's default view names another than Draco's.
// Returns the reason; empty: the encoding is as it was.
[[nodiscard]] absl::StatusOr<std::string> ChooseOpenEncoding(Client& client,
                                                             const std::string& scene,
                                                             v1::ViewOptions& view);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_ENCODINGS_ENCODING_CHOICE_H_
