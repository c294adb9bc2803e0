// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How long this machine takes to decode a point of each codec, in one thread.
//
// Threads  any number may call
#ifndef LATTICED_CLIENT_CPP_LIBRARY_ENCODINGS_DECODE_TIMES_H_
#define LATTICED_CLIENT_CPP_LIBRARY_ENCODINGS_DECODE_TIMES_H_

namespace latticed::client {

// Seconds a point.
struct DecodeTimes {
  double draco = 0, meshopt = 0;
};

// Decodes 8,448 points of a torus that our own writers have written, at the first call: some milliseconds. Later calls return
// the same times.
[[nodiscard]] const DecodeTimes& MeasuredDecodeTimes();

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_ENCODINGS_DECODE_TIMES_H_
