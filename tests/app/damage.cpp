#include "app/damage.h"

#include <fmt/format.h>

#include <array>
#include <cctype>
#include <cstring>
#include <random>
#include <string_view>

#include "scene/gltf_builder.h"

namespace latelight::app {

namespace {

namespace fs = std::filesystem;

Bytes bytesOf(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

Bytes bytesOf(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

// Returns the file and the files next to it that it refers to, if it exists.
void addInstalled(std::vector<GoodScene>& all, const fs::path& path, std::initializer_list<const char*> beside = {}) {
  if (!fs::exists(path)) return;
  GoodScene scene{path.filename().string(), path.filename().string(), {}};
  scene.files[scene.main] = bytesOf(path);
  for (const char* name : beside) scene.files[name] = bytesOf(path.parent_path() / name);
  all.push_back(std::move(scene));
}

void addMade(std::vector<GoodScene>& all, const char* name, Bytes bytes) {
  all.push_back({name, name, {{name, std::move(bytes)}}});
}

// --- mutations ------------------------------------------------------------------------------------------------------

class Random {
 public:
  explicit Random(uint32_t seed) : engine_(seed) {}
  // Returns a number in [0, count), the same on every machine, unlike std::uniform_int_distribution.
  size_t below(size_t count) { return count ? engine_() % count : 0; }

 private:
  std::mt19937_64 engine_;
};

std::string cut(Bytes& bytes, Random& random) {
  const size_t size = random.below(bytes.size());
  bytes.resize(size);
  return fmt::format("cut after {} bytes", size);
}

std::string flipBit(Bytes& bytes, Random& random) {
  const size_t at = random.below(bytes.size()), bit = random.below(8);
  bytes[at] ^= std::byte(1u << bit);
  return fmt::format("bit {} of byte {} flipped", bit, at);
}

std::string flipBytes(Bytes& bytes, Random& random) {
  std::string places;
  for (int i = 0; i < 8; ++i) {
    const size_t at = random.below(bytes.size());
    bytes[at] = std::byte(random.below(256));
    places += fmt::format(" {}", at);
  }
  return "other bytes at" + places;
}

std::string overwriteWord(Bytes& bytes, Random& random) {
  constexpr std::array<uint32_t, 6> kWords{0, 1, 0x7fffffff, 0x80000000, 0xffffffff, 0x7fc00000};
  if (bytes.size() < 4) return flipBit(bytes, random);
  const uint32_t word = kWords[random.below(kWords.size())];
  const size_t at = random.below(bytes.size() - 3);
  std::memcpy(bytes.data() + at, &word, 4);
  return fmt::format("the word at {} becomes {:08x}", at, word);
}

// Replaces a run of digits by another number. JSON and image headers are most sensitive to this.
std::string replaceNumber(Bytes& bytes, Random& random) {
  constexpr std::array<std::string_view, 10> kNumbers{"0",          "-1",  "1",    "1e9",   "4294967295",
                                                      "2147483647", "0.5", "1e40", "65536", "99999999999999999999"};
  const auto isDigit = [&](size_t i) { return std::isdigit(static_cast<unsigned char>(bytes[i])) != 0; };
  const size_t from = random.below(bytes.size());
  for (size_t step = 0; step < bytes.size(); ++step) {
    const size_t begin = (from + step) % bytes.size();
    if (!isDigit(begin) || (begin > 0 && isDigit(begin - 1))) continue;
    size_t end = begin;
    while (end < bytes.size() && isDigit(end)) ++end;
    const std::string_view number = kNumbers[random.below(kNumbers.size())];
    bytes.erase(bytes.begin() + static_cast<ptrdiff_t>(begin), bytes.begin() + static_cast<ptrdiff_t>(end));
    const auto* text = reinterpret_cast<const std::byte*>(number.data());
    bytes.insert(bytes.begin() + static_cast<ptrdiff_t>(begin), text, text + number.size());
    return fmt::format("the number at {} becomes {}", begin, number);
  }
  return flipBit(bytes, random);
}

std::string removeRange(Bytes& bytes, Random& random) {
  const size_t at = random.below(bytes.size());
  const size_t count = std::min(bytes.size() - at, 1 + random.below(64));
  bytes.erase(bytes.begin() + static_cast<ptrdiff_t>(at), bytes.begin() + static_cast<ptrdiff_t>(at + count));
  return fmt::format("{} bytes at {} removed", count, at);
}

std::string repeatRange(Bytes& bytes, Random& random) {
  const size_t at = random.below(bytes.size());
  const size_t count = std::min(bytes.size() - at, 1 + random.below(64));
  const Bytes range(bytes.begin() + static_cast<ptrdiff_t>(at), bytes.begin() + static_cast<ptrdiff_t>(at + count));
  bytes.insert(bytes.begin() + static_cast<ptrdiff_t>(at), range.begin(), range.end());
  return fmt::format("{} bytes at {} repeated", count, at);
}

// A .glb file whose JSON chunk grew or shrank would always fail because of its stated length; this updates the length.
void mendGlb(Bytes& bytes, size_t before) {
  if (bytes.size() < 20 || std::memcmp(bytes.data(), "glTF", 4) != 0 || bytes.size() == before) return;
  uint32_t json = 0;
  std::memcpy(&json, bytes.data() + 12, 4);
  json += static_cast<uint32_t>(bytes.size() - before);
  const auto whole = static_cast<uint32_t>(bytes.size());
  std::memcpy(bytes.data() + 12, &json, 4);
  std::memcpy(bytes.data() + 8, &whole, 4);
}

}  // namespace

const std::vector<GoodScene>& goodScenes() {
  static const std::vector<GoodScene> scenes = [] {
    std::vector<GoodScene> all;
    addMade(all, "punctual.glb", punctualModel());
    addMade(all, "textured.glb", texturedModel());
    addMade(all, "jpeg.glb", texturedModel(PictureKind::Jpeg));
    addMade(all, "webp.glb", texturedModel(PictureKind::Webp));
    addMade(all, "intricate.glb", intricateModel());
    addMade(all, "embedded.gltf", bytesOf(embeddedModel()));
    const fs::path assimp = "/usr/share/assimp/models/glTF2";
    addInstalled(all, assimp / "BoxTextured-glTF/BoxTextured.gltf", {"BoxTextured0.bin", "CesiumLogoFlat.png"});
    addInstalled(all, assimp / "draco/2CylinderEngine.gltf", {"2CylinderEngine.bin"});
    addInstalled(all, assimp / "simple_skin/simple_skin.gltf");
    addInstalled(all, assimp / "cameras/Cameras.gltf", {"simpleSquare.bin"});
    addInstalled(all, fs::path(LATELIGHT_SOURCE_DIR) / "../shared/models/lights_punctual.glb");
    return all;
  }();
  return scenes;
}

const std::vector<GoodScene>& goodPictures() {
  static const std::vector<GoodScene> pictures = [] {
    std::vector<GoodScene> all;
    addMade(all, "sky.hdr", radiancePanorama(64, 32));
    addMade(all, "sky.exr", exrPanorama(64, 32));
    return all;
  }();
  return pictures;
}

Damage damage(const std::vector<GoodScene>& good, uint32_t seed) {
  using Mutation = std::string (*)(Bytes&, Random&);
  constexpr std::array<Mutation, 8> kMutations{cut,           flipBit,       flipBytes,   overwriteWord,
                                               replaceNumber, replaceNumber, removeRange, repeatRange};
  Random random(seed);
  const GoodScene& scene = good[seed % good.size()];
  Damage result{"", scene.main, scene.files};
  const auto file = std::next(result.files.begin(), static_cast<ptrdiff_t>(random.below(result.files.size())));
  const size_t before = file->second.size(), mutation = random.below(kMutations.size());
  result.what =
      fmt::format("case {}, {}: in {}, {}", seed, scene.name, file->first, kMutations[mutation](file->second, random));
  if (kMutations[mutation] == replaceNumber) mendGlb(file->second, before);
  return result;
}

fs::path writeTo(const Folder& folder, const Damage& damage) {
  for (const auto& [name, bytes] : damage.files) folder.write(name, bytes);
  return folder.path() / damage.main;
}

}  // namespace latelight::app
