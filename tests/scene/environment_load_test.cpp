// Loading environments: names, the cache, threads, and real pictures.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "base/error.h"
#include "base/files.h"
#include "base/hash.h"
#include "models/models.h"
#include "own_process.h"
#include "scene/environment/filter.h"
#include "scene/environment_support.h"

namespace latelight::scene {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// A flat Radiance file, the simplest one.
std::vector<std::byte> flatHdr(uint32_t width, uint32_t height, unsigned seed) {
  const std::string header = fmt::format("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {} +X {}\n", height, width);
  std::vector<std::byte> bytes(header.size() + size_t{4} * width * height);
  std::memcpy(bytes.data(), header.data(), header.size());
  std::mt19937 random(seed);
  for (size_t i = header.size(); i < bytes.size(); i += 4) {
    for (size_t c = 0; c < 3; ++c) bytes[i + c] = std::byte(128 + random() % 128);
    bytes[i + 3] = std::byte(126 + random() % 6);
  }
  return bytes;
}

bool same(const RadianceMap& a, const RadianceMap& b) {
  return a.width == b.width && a.height == b.height && a.isFloat == b.isFloat && a.texels == b.texels;
}

bool same(const Environment& a, const Environment& b) {
  if (a.name != b.name || a.specular.size() != b.specular.size()) return false;
  for (size_t i = 0; i < a.specular.size(); ++i) {
    if (!same(a.specular[i], b.specular[i])) return false;
  }
  return same(a.radiance, b.radiance) && same(a.diffuse, b.diffuse);
}

uint64_t digest(const Environment& e) {
  uint64_t h = hash64(e.radiance.texels.data(), e.radiance.texels.size());
  h = hash64(e.diffuse.texels.data(), e.diffuse.texels.size(), h);
  for (const RadianceMap& level : e.specular) h = hash64(level.texels.data(), level.texels.size(), h);
  return h;
}

class EnvironmentLoad : public testing::Test {
 protected:
  fs::path write(const std::string& name, const std::vector<std::byte>& bytes) const {
    writeFile(folder_.path() / name, bytes);
    return folder_.path() / name;
  }
  fs::path cacheEntry() const {
    for (const auto& entry : fs::directory_iterator(folder_.path() / "latelight")) return entry.path();
    return {};
  }
  size_t cacheEntries() const {
    const fs::path cache = folder_.path() / "latelight";
    if (!fs::exists(cache)) return 0;
    return static_cast<size_t>(std::distance(fs::directory_iterator(cache), fs::directory_iterator()));
  }
  std::string failure(const std::string& source) const {
    try {
      loadEnvironment(source);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::BadInput);
      return error.what();
    }
    return "";
  }

  TemporaryFolder folder_;
  ScopedVariable cacheHome_{"XDG_CACHE_HOME", folder_.path().string()};
  ScopedVariable caching_{"LATELIGHT_NO_CACHE", "0"};
};

TEST_F(EnvironmentLoad, NamesTheSource) {
  EXPECT_EQ(loadEnvironment("studio").name, "studio");
  EXPECT_EQ(loadEnvironment(write("my.sky.hdr", flatHdr(16, 8, 1)).string()).name, "my.sky");
}

TEST_F(EnvironmentLoad, SecondLoadIsTheSameBytesFromTheCache) {
  const std::string file = write("a.hdr", flatHdr(64, 32, 2));
  const Environment first = loadEnvironment(file);
  ASSERT_EQ(cacheEntries(), 1u);
  EXPECT_TRUE(same(first, loadEnvironment(file)));

  // The second call did read the entry: one with a valid checksum but another pixel is returned as it is.
  const std::string name = cacheEntry().filename();
  std::vector<std::byte> entry = loadCache(name).value();
  entry.back() ^= std::byte{1};
  storeCache(name, entry);
  EXPECT_FALSE(same(first, loadEnvironment(file)));
}

TEST_F(EnvironmentLoad, SunsBeyondHalvesComeBackFromTheCache) {
  std::vector<std::byte> bytes = flatHdr(64, 32, 2);
  const size_t sun = bytes.size() - 4 * (64 * 20 + 7);
  bytes[sun] = bytes[sun + 1] = bytes[sun + 2] = std::byte{128};
  bytes[sun + 3] = std::byte{129 + 20};  // 128 / 256 * 2^(149 - 128)
  const std::string file = write("a.hdr", bytes);
  const Environment first = loadEnvironment(file), second = loadEnvironment(file);
  ASSERT_EQ(cacheEntries(), 1u);
  EXPECT_TRUE(first.radiance.isFloat && first.specular[0].isFloat);
  EXPECT_TRUE(same(first, second));
  EXPECT_EQ(second.radiance.at(64 - 7, 32 - 20 - 1).x, 0x1p20f);
}

TEST_F(EnvironmentLoad, OtherPicturesHaveOtherEntries) {
  const Environment first = loadEnvironment(write("a.hdr", flatHdr(64, 32, 3)));
  const Environment second = loadEnvironment(write("a.hdr", flatHdr(64, 32, 4)));
  EXPECT_FALSE(same(first, second)) << "the same name with other contents";
  EXPECT_EQ(cacheEntries(), 2u);
}

TEST_F(EnvironmentLoad, BrokenCacheEntriesAreComputedAgain) {
  const std::string file = write("a.hdr", flatHdr(32, 16, 5));
  const Environment good = loadEnvironment(file);
  const fs::path path = cacheEntry();
  const std::vector<std::byte> raw = readFile(path);
  for (const size_t length : {size_t{0}, size_t{5}, size_t{100}, raw.size() / 2, raw.size() - 1}) {
    writeFile(path, std::span(raw).first(length));
    EXPECT_TRUE(same(good, loadEnvironment(file))) << "truncated to " << length;
  }
  // Invalid contents with a valid checksum, as another program or version might write them.
  const std::string name = path.filename();
  const std::vector<std::byte> entry = loadCache(name).value();
  for (const size_t at : {0u, 4u, 8u, 15u, 16u, 17u, 24u, 27u, 28u, 33u, 44u}) {
    std::vector<std::byte> changed = entry;
    changed[at] ^= std::byte{0x55};
    storeCache(name, changed);
    const Environment again = loadEnvironment(file);
    EXPECT_TRUE(same(good, again)) << "byte " << at;
  }
  std::vector<std::byte> longer = entry;
  longer.resize(entry.size() + 8);
  storeCache(name, longer);
  EXPECT_TRUE(same(good, loadEnvironment(file)));
}

TEST_F(EnvironmentLoad, WorksWithoutACache) {
  const std::string file = write("a.hdr", flatHdr(32, 16, 6));
  const Environment cached = loadEnvironment(file);
  fs::remove_all(folder_.path() / "latelight");
  const ScopedVariable off("LATELIGHT_NO_CACHE", "1");
  EXPECT_TRUE(same(cached, loadEnvironment(file)));
  EXPECT_EQ(cacheEntries(), 0u);
}

TEST_F(EnvironmentLoad, ErrorsNameTheFile) {
  EXPECT_THAT(failure("no/such/file.hdr"), HasSubstr("no/such/file.hdr"));
  EXPECT_THAT(failure("studios"), HasSubstr("studios"));
  const std::string text = write("text.hdr", std::vector<std::byte>(100, std::byte{'x'}));
  EXPECT_THAT(failure(text), testing::AllOf(HasSubstr("text.hdr"), HasSubstr("neither")));
  EXPECT_THAT(failure(write("empty.exr", {})), HasSubstr("empty.exr"));
  EXPECT_EQ(cacheEntries(), 0u) << "failures leave nothing in the cache";
}

// The next test runs this in processes of their own, because a process has one pool of threads.
TEST(EnvironmentDigestInAProcess, DISABLED_Print) {
  const FloatImage picture = decodePicture(flatHdr(300, 150, 7), "memory");
  std::ofstream(std::getenv("LATELIGHT_TEST_DIGEST")) << digest(filterEnvironment(picture));
}

TEST_F(EnvironmentLoad, IsTheSameForAnyNumberOfThreads) {
  std::vector<std::string> digests;
  for (const char* threads : {"1", "2", "5"}) {
    const fs::path file = folder_.path() / threads;
    const ScopedVariable count("LATELIGHT_THREADS", threads), output("LATELIGHT_TEST_DIGEST", file.string());
    const pid_t child = fork();
    if (child == 0) {
      test::runAllShardsInChildren();
      execl("/proc/self/exe", "test", "--gtest_filter=EnvironmentDigestInAProcess.*", "--gtest_also_run_disabled_tests",
            "--gtest_brief=1", nullptr);
      _exit(127);
    }
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    ASSERT_EQ(status, 0);
    const std::vector<std::byte> text = readFile(file);
    digests.emplace_back(reinterpret_cast<const char*>(text.data()), text.size());
    EXPECT_GT(digests.back().size(), 5u);
  }
  EXPECT_EQ(digests[0], digests[1]);
  EXPECT_EQ(digests[0], digests[2]);
}

// A day: blue above, earth below, with the sun's side `factor` times as bright as the other.
TEST_F(EnvironmentLoad, Panoramas) {
  const auto expectDay = [](const std::string& name, float factor) {
    SCOPED_TRACE(name);
    const Environment e = loadEnvironment(models::modelPath(name));
    EXPECT_EQ(e.name, fs::path(name).stem());
    EXPECT_EQ(e.radiance.width, 1024u);
    EXPECT_EQ(e.radiance.height, 512u);
    const glm::vec3 up = lookUp(e.diffuse, {0, 0, 1}), down = lookUp(e.diffuse, {0, 0, -1});
    EXPECT_GT(up.z, up.x);
    EXPECT_GT(down.x, down.z);
    EXPECT_GT(lookUp(e.diffuse, {1, 0, 0}).y, factor * lookUp(e.diffuse, {-1, 0, 0}).y);
  };
  expectDay("sky.hdr", 1.3f);
  expectDay("sky.exr", 1.3f);
  for (const std::string& name : models::withReal({}, {"spiaggia_1k.hdr"})) expectDay(name, 3);
}

// A file of our own, and Debian's blender-data if it is installed.
TEST_F(EnvironmentLoad, Exrs) {
  std::vector<fs::path> files{models::modelPath("sky.exr")};
  const fs::path world = "/usr/share/blender/datafiles/studiolights/world";
  if (fs::exists(world)) {
    for (const auto& entry : fs::directory_iterator(world))
      if (entry.path().extension() == ".exr") files.push_back(entry.path());
    EXPECT_GE(files.size(), 6u);
    EXPECT_GT(lookUp(loadEnvironment(world / "forest.exr").diffuse, {0, 0, 1}).y, 0.05f);
  } else {
    std::printf("Debian's blender-data is not installed: only an .exr that the tests make is read\n");
  }
  for (const fs::path& file : files) {
    const FloatImage picture = readPicture(file);
    EXPECT_EQ(picture.width, 2 * picture.height) << file;
    EXPECT_GE(picture.width, 256u) << file;
    EXPECT_GE(std::ranges::max(picture.pixels), 1.0f) << file;
  }
}

}  // namespace
}  // namespace latelight::scene
