# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# find_package(latticed CONFIG REQUIRED): the target latticed::client and what its static libraries link.
include(CMakeFindDependencyMacro)
find_dependency(Threads)
find_dependency(absl CONFIG)
find_dependency(OpenSSL)
find_dependency(Protobuf)  # module mode, and before gRPC: Debian ships no protobuf-config.cmake
find_dependency(gRPC CONFIG)
find_dependency(draco CONFIG)
find_dependency(hwy CONFIG)
find_dependency(fmt CONFIG)
include(${CMAKE_CURRENT_LIST_DIR}/latticed-targets.cmake)
