// The reservation of disk space for the index of Mesa's shader cache, on a full disk and with unusual files.
#include "vk/driver_cache.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "small_disk.h"

namespace latelight::vk {
namespace {

namespace fs = std::filesystem;

constexpr uintmax_t kIndexBytes = 1310728;  // as in Mesa 22.3

// Creates a sparse index in the cache folder below `base`, and sets the environment variable to `base`.
fs::path makeIndex(const fs::path& base) {
  setenv("MESA_SHADER_CACHE_DIR", base.c_str(), 1);
  const fs::path index = base / "mesa_shader_cache" / "index";
  fs::create_directories(index.parent_path());
  std::ofstream(index).put('m');
  fs::resize_file(index, kIndexBytes);
  return index;
}

intmax_t bytesOnDisk(const fs::path& path) {
  struct stat status {};
  return stat(path.c_str(), &status) == 0 ? status.st_blocks * 512 : -1;
}

class DriverCache : public testing::Test {
 protected:
  DriverCache() : before_(std::getenv("MESA_SHADER_CACHE_DIR") ? std::getenv("MESA_SHADER_CACHE_DIR") : "") {}
  ~DriverCache() override {
    before_.empty() ? unsetenv("MESA_SHADER_CACHE_DIR") : setenv("MESA_SHADER_CACHE_DIR", before_.c_str(), 1);
  }

 private:
  std::string before_;
};

TEST_F(DriverCache, FillsTheHolesOfTheIndexAndKeepsItsContents) {
  const test::SmallDisk disk(4u << 20);
  if (!disk) GTEST_SKIP() << "This user may not mount a small disk.";
  const fs::path index = makeIndex(disk.path());
  ASSERT_LT(bytesOnDisk(index), static_cast<intmax_t>(kIndexBytes));
  EXPECT_TRUE(reserveDriverCache());
  EXPECT_GE(bytesOnDisk(index), static_cast<intmax_t>(kIndexBytes));
  EXPECT_EQ(fs::file_size(index), kIndexBytes);
  EXPECT_EQ(std::ifstream(index).get(), 'm');
  disk.fill();
  EXPECT_TRUE(reserveDriverCache()) << "what is reserved needs no more room";
}

TEST_F(DriverCache, FailsOnAFullDisk) {
  const test::SmallDisk disk(64u << 10);
  if (!disk) GTEST_SKIP() << "This user may not mount a small disk.";
  setenv("MESA_SHADER_CACHE_DIR", (disk.path() / "not" / "there").c_str(), 1);
  EXPECT_FALSE(reserveDriverCache()) << "the driver has made nothing yet";
  makeIndex(disk.path());
  disk.fill();
  EXPECT_FALSE(reserveDriverCache());
}

TEST_F(DriverCache, IgnoresAPipeInPlaceOfTheIndex) {
  std::string name = (fs::temp_directory_path() / "latelight-cache-XXXXXX").string();
  const fs::path base = mkdtemp(name.data());
  const fs::path index = makeIndex(base);
  fs::remove(index);
  ASSERT_EQ(mkfifo(index.c_str(), 0600), 0);
  EXPECT_TRUE(reserveDriverCache());
  fs::remove_all(base);
}

}  // namespace
}  // namespace latelight::vk
