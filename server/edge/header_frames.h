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
//   a frame     one that goes on in another has too much as soon as it has a field; the same of a header
//               that belongs to no call, where a field does not end in its frame
//   of kMaxHeaderBytes of fields, in twice as many bytes at most
//
// or it is an error of its connection, as with gRPC by itself. Clients need no more: 8 KiB are what the
// settings allow, and frames may be 16 KiB. With any other gRPC header_frames_stub.cc is here: how these
// functions return, and what they take, is that version's.
//
// Threads  safe
#ifndef LATTICED_SERVER_EDGE_HEADER_FRAMES_H_
#define LATTICED_SERVER_EDGE_HEADER_FRAMES_H_

namespace latticed {

// Whether gRPC comes here: the first time by a header of its own, in some milliseconds. It does not
// where its library is linked with -Bsymbolic-functions.
[[nodiscard]] bool HeadersAreBounded();

}  // namespace latticed

#endif  // LATTICED_SERVER_EDGE_HEADER_FRAMES_H_
