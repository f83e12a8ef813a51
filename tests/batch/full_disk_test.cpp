// A disk that fills up while a data set is written, for each format: the batch ends with a promised exit code and its
// messages, every file that exists is whole, and --resume completes the set.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <sstream>

#include "batch/sets.h"
#include "small_disk.h"

namespace latelight::data {
namespace {

namespace fs = std::filesystem;
using app::Folder;
using app::latelight;
using app::Outcome;

class FullDisk : public testing::TestWithParam<std::string> {
 protected:
  static Outcome make(const Folder& folder, const std::string& set, std::vector<std::string> more = {}) {
    std::vector<std::string> job{"--scenes",  "builtin:boxes",
                                 "--cameras", R"({"type": "orbit", "count": 6})",
                                 "--threads", "1",
                                 "--formats", GetParam(),
                                 "-o",        set};
    job.insert(job.end(), more.begin(), more.end());
    return latelight(batch(folder, job));
  }

  // The bytes of a set's files and the batch's own files on a disk whose blocks are pages.
  static size_t bytesOnDisk(const fs::path& set) {
    constexpr size_t kPage = 4096;
    size_t pages = 0;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(set))
      if (entry.is_regular_file()) pages += (entry.file_size() + kPage - 1) / kPage;
    return pages * kPage;
  }

  // Every line is one sentence that names the program, a frame or a file.
  static void expectSentences(const Outcome& outcome) {
    std::istringstream lines(outcome.err);
    size_t count = 0;
    for (std::string line; std::getline(lines, line); ++count) EXPECT_FALSE(line.empty());
    EXPECT_GE(count, 1u);
    EXPECT_TRUE(outcome.err.find("latelight: ") != std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.err.find("terminate"), std::string::npos) << outcome.err;
  }
};

TEST_P(FullDisk, LeavesOnlyWholeFiles) {
  Folder folder;
  const Outcome undisturbed = make(folder, "whole");
  ASSERT_EQ(undisturbed.code, 0) << undisturbed.text();
  const auto whole = filesOf(folder, "whole");
  const size_t needed = bytesOnDisk(folder.path() / "whole");
  // It fills up at the first frame, in the middle, and at the last files, which describe the whole set.
  for (const double share : {0.15, 0.5, 0.8, 0.95}) {
    const test::SmallDisk disk(size_t(std::ceil(share * double(needed))));
    if (!disk) GTEST_SKIP() << "no right to mount";
    const std::string link = "disk" + std::to_string(int(100 * share));
    fs::create_directory_symlink(disk.path(), folder.path() / link);
    const Outcome full = make(folder, link + "/set");
    if (share > 0.9 && full.code == 0) continue;  // the size is an estimate
    EXPECT_THAT(full.code, testing::AnyOf(2, 6)) << share << ": " << full.text();
    expectSentences(full);
    auto there = filesOf(folder, link + "/set");
    there.erase("manifest.json");  // without the missing frames
    for (const auto& [name, bytes] : there) {
      const bool waits = name.find(".frames/") != std::string::npos;  // a frame that an archive will contain
      if (!waits) {
        EXPECT_TRUE(whole.contains(name) && whole.at(name) == bytes) << share << ": " << name << " is torn";
      }
    }
    for (const auto& entry : fs::recursive_directory_iterator(disk.path()))
      EXPECT_EQ(entry.path().filename().string().find("latelight-tmp"), std::string::npos) << entry.path();
    ASSERT_EQ(mount("tmpfs", disk.path().c_str(), "tmpfs", MS_REMOUNT, "size=64M"), 0);
    const Outcome resumed = make(folder, link + "/set", {"--resume"});
    EXPECT_EQ(resumed.code, 0) << share << ": " << resumed.text();
    expectSame(filesOf(folder, link + "/set"), whole);
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, FullDisk,
                         testing::Values("hdf5", "webdataset", "colmap", "transforms", "scannet", "yolo", "kitti",
                                         "voc", "correspondence"),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace latelight::data
