// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Decodes the streams of ENCODING_MESHOPT that latticed writes (core/codec/meshopt/meshopt_format.h). Others are refused,
// also if meshoptimizer would decode them: with other modes, or numbers of more bits than the form says.
//
// Threads  pure
#ifndef LATTICED_CLIENT_DECODER_MESHOPT_MESHOPT_READER_H_
#define LATTICED_CLIENT_DECODER_MESHOPT_MESHOPT_READER_H_

#include "client/decoder/chunk_decoder.h"

namespace latticed::decoder {

// Sets the results of `job`, which has a point at least.
void DecodeMeshopt(const ChunkForm& form, ChunkJob& job);

}  // namespace latticed::decoder

#endif  // LATTICED_CLIENT_DECODER_MESHOPT_MESHOPT_READER_H_
