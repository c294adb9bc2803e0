// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A machine that loses its power: ext4 on a loop device is shut down without writing what it holds back. The server is
// stopped first. Otherwise it could acknowledge what the filesystem, already shut down, only seems to have written.
//
// With full durability nothing acknowledged is lost; with async something must be, or the test tests nothing.
#include <fcntl.h>
#include <linux/fs.h>
#include <sys/ioctl.h>
#include <sys/mount.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <map>
#include <random>
#include <string>

#include "fmt/format.h"
#include "gtest/gtest.h"
#include "server/store/sqlite_store.h"
#include "tests/server/store/crash/lost_records.h"
#include "tests/server/store/crash/numbered_records.h"
#include "tests/server/store/crash/running_child.h"
#include "tests/support/status_matchers.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

constexpr int kPowerLosses = 100;
// EXT4_IOC_SHUTDOWN, and not to write the journal first; <linux/fs.h> has them only since 6.8.
constexpr unsigned long kShutDown = _IOR('X', 125, uint32_t);
constexpr uint32_t kWithoutFlush = 2;

bool Runs(const std::string& command) {
  return std::system((command + " >/dev/null 2>&1").c_str()) == 0;
}

// ext4 in a file, mounted on a folder.
class LoopDisk {
 public:
  explicit LoopDisk(const TemporaryFolder& folder)
      : image_(folder.Path("image")), mount_(folder.Path("disk")) {}
  ~LoopDisk() { Unmount(); }
  LoopDisk(const LoopDisk&) = delete;  // one mount
  LoopDisk& operator=(const LoopDisk&) = delete;

  bool Make() {
    return Runs(
        fmt::format("truncate -s 256M {0} && mkfs.ext4 -q -F {0} && mkdir {1}", image_, mount_));
  }
  bool Mount() { return mounted_ = Runs(fmt::format("mount -o loop {} {}", image_, mount_)); }
  void Unmount() {
    if (mounted_) umount2(mount_.c_str(), 0);
    mounted_ = false;
  }
  bool LosePower() {
    const int folder = open(mount_.c_str(), O_RDONLY | O_DIRECTORY);
    uint32_t flags = kWithoutFlush;
    const bool lost = ioctl(folder, kShutDown, &flags) == 0;
    close(folder);
    return lost;
  }
  const std::string& path() const { return mount_; }

 private:
  const std::string image_;
  const std::string mount_;
  bool mounted_ = false;
};

class StorePowerLoss : public ::testing::Test {
 protected:
  // How many acknowledged records are lost in a power loss after `time` of work; -1: the disk cannot lose its power.
  int64_t Lost(LoopDisk& disk, const std::string& durability, absl::Duration time) {
    const std::string data = disk.path() + "/data";
    {
      RunningChild child(data, durability, 20);
      EXPECT_TRUE(child.Work(time));
      child.Stop();
      acknowledged_ = child.acknowledged();
      if (!disk.LosePower()) return -1;
    }
    disk.Unmount();
    EXPECT_TRUE(disk.Mount());
    const auto store = OpenSqliteStore({.folder = data});
    EXPECT_OK(store);
    return store.ok() ? static_cast<int64_t>(LostOf(acknowledged_, **store)) : 1;
  }

  std::map<std::string, uint64_t> acknowledged_;
  std::mt19937 random_{23};
};

TEST_F(StorePowerLoss, LosesNothingThatIsDurable) {
  const TemporaryFolder folder;
  LoopDisk disk(folder);
  if (!disk.Make() || !disk.Mount()) GTEST_SKIP() << "no loop device can be mounted here";

  for (int i = 0; i < Faults(kPowerLosses); ++i) {
    SCOPED_TRACE(i);
    const int64_t lost = Lost(disk, "full", absl::Milliseconds(random_() % 400));
    if (lost < 0) GTEST_SKIP() << "this kernel cannot shut a filesystem down";
    EXPECT_EQ(lost, 0);
  }
}

TEST_F(StorePowerLoss, LosesWhatIsNot) {
  const TemporaryFolder folder;
  LoopDisk disk(folder);
  if (!disk.Make() || !disk.Mount()) GTEST_SKIP() << "no loop device can be mounted here";

  int64_t lost = 0;
  // A machine that is short of memory may have written everything by itself.
  for (int i = 0; i < 50 && lost == 0; ++i) {
    lost = Lost(disk, "async", absl::Milliseconds(100 + random_() % 300));
    if (lost < 0) GTEST_SKIP() << "this kernel cannot shut a filesystem down";
  }
  EXPECT_GT(lost, 0);
}

}  // namespace
}  // namespace latticed::testing
