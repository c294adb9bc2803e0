// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Bounds what headers of HTTP/2 make gRPC 1.51 hold. By itself it buffers a field of any length until it
// has ended, copying what it has with each piece (CVE-2023-33953), counts the bytes of a header anew
// with each frame, and grants 16 MiB of them until its settings are acknowledged. 80 MiB sent by 40
// connections took 840 MB, 120 MiB by six 98 seconds of processor time: tests/bench/long_headers.py.
//
// So three functions of gRPC's have namesakes here, which the dynamic linker finds first, since a program
// comes before its libraries, and which call gRPC's. A header may be
//
//   a frame     one that goes on in another has too much, as soon as it has a field; so has a frame
//               without end that belongs to no call
//   of kMaxHeaderBytes of fields, in twice as many bytes at most
//
// or it is an error of its connection. Clients need no more: 8 KiB are what the settings allow, and
// frames may be 16 KiB.
//
// Threads  safe
#ifndef LATTICED_SERVER_HEADER_FRAMES_H_
#define LATTICED_SERVER_HEADER_FRAMES_H_

namespace latticed {

// Whether gRPC was seen to come here, as it has where a call came over a network. Not where its library
// is another version, or is linked with -Bsymbolic.
[[nodiscard]] bool HeadersAreBounded();

}  // namespace latticed

#endif  // LATTICED_SERVER_HEADER_FRAMES_H_
