# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# For find_package(latticed CONFIG REQUIRED): the target latticed::client, and the packages that it links.
include(CMakeFindDependencyMacro)
find_dependency(Threads)
find_dependency(absl CONFIG)
find_dependency(OpenSSL)
find_dependency(Protobuf)  # in module mode and before gRPC, since Debian ships no protobuf-config.cmake
find_dependency(gRPC CONFIG)
find_dependency(draco CONFIG)
find_dependency(hwy CONFIG)
find_dependency(fmt CONFIG)
find_dependency(ZLIB)
include(${CMAKE_CURRENT_LIST_DIR}/latticed-targets.cmake)
