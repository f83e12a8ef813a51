// Damaged camera files: each is read, or ends with one sentence that names the file.
#include <fmt/format.h>

#include "data/cameras/bop.h"
#include "data/cameras/colmap.h"
#include "data/cameras/transforms.h"
#include "data/cameras/tum.h"
#include "data/random.h"
#include "data_cameras/support.h"

namespace latelight::data::test {
namespace {

std::vector<CalibratedCamera> someCameras() {
  std::vector<CalibratedCamera> cameras;
  const scene::Lens lens{.width = 64, .height = 48, .fx = 50, .fy = 51, .cx = 32, .cy = 24};
  for (int i = 0; i < 3; ++i) cameras.push_back({fmt::format("{}", i), lens, dmat4(1)});
  return cameras;
}

std::string damaged(std::string text, Random& random) {
  constexpr std::string_view kBits[] = {"1e999", "-1",  "nan", "0", "[[", "}", "\"", "18446744073709551615",
                                        "\n",    "null"};
  for (uint32_t changes = 1 + random.below(3); changes > 0 && !text.empty(); --changes) {
    const uint32_t at = random.below(static_cast<uint32_t>(text.size()));
    switch (random.below(5)) {
      case 0:
        text.resize(at);
        break;
      case 1:
        text[at] = static_cast<char>(random.below(256));
        break;
      case 2:
        text.insert(at, kBits[random.below(std::size(kBits))]);
        break;
      case 3:
        text.erase(at, random.below(20));
        break;
      default:
        for (size_t i = at; i < std::min<size_t>(text.size(), at + 8); ++i) text[i] = static_cast<char>(0xff);
    }
  }
  return text;
}

// Files by name; read() reads them from the folder.
template <typename Read>
void expectHarmless(const Folder& folder, const std::vector<std::string>& names, const Read& read) {
  std::map<std::string, std::string> good;
  for (const std::string& name : names) good[name] = folder.read(name);
  uint32_t refused = 0;
  for (uint64_t i = 0; i < 300; ++i) {
    Random random(11, i, names[0]);
    const std::string& victim = names[random.below(static_cast<uint32_t>(names.size()))];
    folder.write(victim, damaged(good[victim], random));
    try {
      for (const CalibratedCamera& camera : read())
        for (int column = 0; column < 4; ++column) ASSERT_TRUE(std::isfinite(glm::length(camera.pose[column])));
    } catch (const Error& error) {
      ++refused;
      EXPECT_EQ(error.code(), ExitCode::BadInput) << error.what();
      EXPECT_THAT(error.what(), testing::HasSubstr(folder.path().string()));
      EXPECT_EQ(std::string_view(error.what()).find('\n'), std::string_view::npos);
    }
    folder.write(victim, good[victim]);
  }
  EXPECT_GT(refused, 60u);
}

TEST(HostileTest, ColmapBinary) {
  const Folder folder;
  writeColmapBinary(folder.path(), someCameras());
  expectHarmless(folder, {"cameras.bin", "images.bin"}, [&] { return readColmap(folder.path()); });
}

TEST(HostileTest, ColmapText) {
  const Folder folder;
  writeColmapText(folder.path(), someCameras());
  expectHarmless(folder, {"cameras.txt", "images.txt"}, [&] { return readColmap(folder.path()); });
}

TEST(HostileTest, Transforms) {
  const Folder folder;
  writeTransforms(folder.path() / "t.json", someCameras());
  expectHarmless(folder, {"t.json"}, [&] { return readTransforms(folder.at("t.json")); });
}

TEST(HostileTest, Tum) {
  const Folder folder;
  writeTum(folder.path() / "t.txt", someCameras());
  expectHarmless(folder, {"t.txt"}, [&] { return readTum(folder.at("t.txt")); });
}

TEST(HostileTest, Bop) {
  const Folder folder;
  writeBop(folder.path() / "b.json", someCameras(), 1);
  expectHarmless(folder, {"b.json"}, [&] { return readBop(folder.at("b.json"), {64, 48}); });
}

TEST(HostileTest, SaysWhere) {
  const Folder folder;
  writeColmapBinary(folder.path(), someCameras());
  const std::string cameras = folder.read("cameras.bin"), images = folder.read("images.bin");
  const auto reads = [&](const std::string& lensFile, const std::string& imageFile) {
    folder.write("cameras.bin", lensFile);
    folder.write("images.bin", imageFile);
    return errorOf([&] { readColmap(folder.path()); }, ExitCode::BadInput);
  };
  EXPECT_THAT(reads(std::string("\xff\xff\xff\xff\xff\xff\xff\x7f", 8) + cameras.substr(8), images),
              testing::HasSubstr("byte 0 of " + folder.at("cameras.bin") + " declares 9223372036854775807 entries"));
  EXPECT_THAT(reads(cameras.substr(0, 40), images), testing::HasSubstr("ends at byte 40"));
  EXPECT_THAT(reads(cameras, images.substr(0, images.size() - 3)), testing::HasSubstr(folder.at("images.bin")));
  std::string unknown = cameras;
  unknown[12] = 99;
  EXPECT_THAT(reads(unknown, images), testing::HasSubstr("byte 8 of"));
  folder.write("t.json", "{\"frames\": [\n\n{\"a\": }]}");
  EXPECT_THAT(errorOf([&] { readTransforms(folder.at("t.json")); }, ExitCode::BadInput),
              testing::HasSubstr("t.json:3: it is not JSON"));
  folder.write("t.json", std::string(100000, '['));
  EXPECT_THAT(errorOf([&] { readTransforms(folder.at("t.json")); }, ExitCode::BadInput),
              testing::HasSubstr("t.json:1: it is nested deeper than 64 levels"));
}

}  // namespace
}  // namespace latelight::data::test
