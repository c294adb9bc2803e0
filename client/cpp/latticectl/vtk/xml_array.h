// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The numbers of a DataArray. https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html, "XML file formats":
//
//   plain       a count of bytes, the bytes
//   compressed  counts of blocks, of bytes in a block, of bytes in the last block if it is shorter (0: it is not), of
//               compressed bytes in each block; the blocks by zlib. In Base64 the counts are a text of their own
//
// Counts are UInt32 or UInt64, by header_type.
//
// Errors   kInvalidArgument in one sentence, without the file's name
// Threads  pure functions
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_VTK_XML_ARRAY_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_VTK_XML_ARRAY_H_

#include <bit>
#include <cstddef>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace latticed::client {

// How a file codes its binary arrays.
struct XmlCoding {
  std::endian order = std::endian::little;
  size_t count_bytes = 4;
  bool is_compressed = false;
};

// The bytes of an array that begins where `text` does.
[[nodiscard]] absl::StatusOr<std::string> XmlArrayBytes(std::string_view text, bool is_base64,
                                                        const XmlCoding& coding);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_VTK_XML_ARRAY_H_
