// Damaged files load or are rejected with a message that names the file. Every run tries the same ones.
#include <random>

#include "base/log.h"
#include "long_tests.h"
#include "mesh_files/support.h"

namespace latelight::scene::test {
namespace {

struct Good {
  std::string name, text;
};

std::vector<Good> goodFiles() {
  std::string stl(80, ' ');
  stl += bytesOf<uint32_t>({2}) + std::string(100, '\1');
  const std::string ascii =
      "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
      "endfacet\nendsolid a\n";
  const std::string header =
      "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar "
      "green\n"
      "property uchar blue\nelement face 2\nproperty list uchar int vertex_indices\nproperty list uchar float "
      "texcoord\n"
      "end_header\n";
  std::string text = "ply\nformat ascii 1.0\ncomment TextureFile t.png\n" + header,
              binary = "ply\nformat binary_little_endian 1.0\n" + header;
  for (int i = 0; i < 4; ++i) {
    text += fmt::format("{} {} 0 1 2 3\n", i % 2, i / 2);
    binary += bytesOf<float>({float(i % 2), float(i / 2), 0}) + std::string("\1\2\3");
  }
  for (int i = 0; i < 2; ++i) {
    text += "4 0 1 3 2 8 0 0 1 0 1 1 0 1\n";
    binary += std::string("\4") + bytesOf<int32_t>({0, 1, 3, 2}) + std::string("\2") + bytesOf<float>({0, 1});
  }
  const std::string obj =
      "mtllib m.mtl\no a\nv 0 0 0\nv 1 0 0 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 1\nvn 0 0 1\ng b c\nusemtl m\ns 1\n"
      "f 1/1/1 2/2/1 3/1/1 4/2/1\nf -4 -3 \\\n-2 -1\ns off\nf 1 2 3\n";
  return {{"a.stl", stl}, {"b.stl", ascii}, {"c.ply", text}, {"d.ply", binary}, {"e.obj", obj}};
}

const std::string kMtl =
    "newmtl m\nKd 1 0 0\nKs 1 1 1\nNs 20\nd 0.5\nPr 0.5\nmap_Kd -s 2 2 t.png\nbump -bm 2 t.png\nmap_d -imfchan r "
    "t.png\n"
    "newmtl n\nPm 1\nnorm t.png\n";

void damage(std::string& text, std::mt19937_64& random) {
  const auto below = [&](size_t count) { return count ? random() % count : 0; };
  constexpr std::array kWords = {"1000000000",
                                 "-1",
                                 "nan",
                                 "inf",
                                 "1e999",
                                 "4294967295",
                                 "../../etc/passwd",
                                 "/dev/zero",
                                 "-99999999999999999999",
                                 "\\",
                                 "#",
                                 "0",
                                 "list",
                                 "\n",
                                 " ",
                                 "vertex",
                                 "%s%n"};
  switch (below(6)) {
    case 0:
      text.resize(below(text.size()));
      break;
    case 1:
      for (int i = 0; i < 4 && !text.empty(); ++i) text[below(text.size())] = char(below(256));
      break;
    case 2: {  // a number or word becomes another one
      const size_t at = text.find_first_of(" \n", below(text.size()));
      if (at == std::string::npos) break;
      const size_t end = std::min(text.find_first_of(" \n/", at + 1), text.size());
      text.replace(at + 1, end - at - 1, kWords[below(kWords.size())]);
      break;
    }
    case 3: {  // a range is repeated
      const size_t at = below(text.size()), length = below(64);
      text.insert(at, text.substr(at, length));
      break;
    }
    case 4: {
      const uint32_t words[] = {0, 0x7fffffff, 0x80000000, 0xffffffff, 0x7fc00000, 0x7f800000};
      if (text.size() > 4) std::memcpy(text.data() + below(text.size() - 4), &words[below(6)], 4);
      break;
    }
    default:
      text.erase(below(text.size()), below(32));
  }
}

TEST(DamagedMeshFiles, LoadOrAreRejected) {
  setQuiet(true);
  const std::string image = png(2, 2, {{1, 2, 3, 4}, {5, 6, 7, 8}, {9, 10, 11, 12}, {200, 100, 50, 25}});
  size_t loaded = 0, rejected = 0;
  const int count = latelight::test::rounds(20'000, 500);
  for (int i = 0; i < count; ++i) {
    std::mt19937_64 random(static_cast<uint64_t>(i));
    const std::vector<Good> files = goodFiles();
    Good file = files[size_t(i) % files.size()];
    std::string mtl = kMtl;
    const bool damagesMtl = file.name == "e.obj" && random() % 2 == 0;
    for (uint64_t n = 1 + random() % 3; n > 0; --n) damage(damagesMtl ? mtl : file.text, random);
    MeshFile scene(file.name, file.text);
    scene.add("m.mtl", mtl).add("t.png", image);
    try {
      loaded += scene.load({.pointRadius = 0.1f}).triangleCount() > 0;
    } catch (const Error& error) {
      ++rejected;
      EXPECT_EQ(error.code(), ExitCode::BadInput) << i << ": " << error.what();
      EXPECT_THAT(error.what(), testing::HasSubstr(file.name)) << i;
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << i << ": " << error.what();
    }
  }
  setQuiet(false);
  // The damage must be neither harmless nor fatal in all cases.
  EXPECT_GT(loaded, size_t(count) / 10);
  EXPECT_GT(rejected, size_t(count) / 10);
}

TEST(DamagedMeshFiles, SoundFilesLoad) {
  for (const Good& file : goodFiles()) {
    MeshFile scene(file.name, file.text);
    scene.add("m.mtl", kMtl).add("t.png", png(1, 1, {{1, 2, 3, 4}}));
    EXPECT_GT(scene.load().triangleCount(), 0u) << file.name;
  }
}

}  // namespace
}  // namespace latelight::scene::test
