// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Headers that most tests include and that take long to parse. The build precompiles this file for the
// tests; no file includes it.
#ifndef LATTICED_TESTS_SUPPORT_PRECOMPILED_H_
#define LATTICED_TESTS_SUPPORT_PRECOMPILED_H_

#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <random>
#include <set>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "fmt/format.h"
#include "latticed/v1/mesh.grpc.pb.h"
#include "latticed/v1/scene.grpc.pb.h"
#include "latticed/v1/server.grpc.pb.h"

#endif  // LATTICED_TESTS_SUPPORT_PRECOMPILED_H_
