// A thousand damaged files: each one loads or throws Error; no other result is accepted.
#include <gtest/gtest.h>

#include <cstdlib>
#include <random>

#include "base/log.h"
#include "gltf_busy_file.h"
#include "gltf_compressed_files.h"
#include "scene/gltf/load.h"

namespace latelight::scene::test {
namespace {

namespace fs = std::filesystem;

struct Sample {
  std::string name;
  std::vector<std::byte> bytes;
};

std::vector<std::byte> bytesOf(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::vector<char> text((std::istreambuf_iterator<char>(in)), {});
  auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

std::vector<Sample> samples() {
  GltfBuilder busy = busyFile();
  std::string text = busy.embedded();
  auto bytes = std::as_bytes(std::span(text));
  std::vector<Sample> out = {{"busy.glb", busy.glb()}, {"busy.gltf", {bytes.begin(), bytes.end()}}};
  out.push_back({"meshopt.glb", meshoptFile().glb()});
  out.push_back({"draco_sequential.glb", dracoFile(draco::MESH_SEQUENTIAL_ENCODING).glb()});
  out.push_back({"draco_edgebreaker.glb", dracoFile(draco::MESH_EDGEBREAKER_ENCODING).glb()});
  fs::path assimp = "/usr/share/assimp/models/glTF2";
  for (const char* name : {"BoxTextured-glTF-Binary/BoxTextured.glb", "BoxTextured-glTF-Embedded/BoxTextured.gltf",
                           "simple_skin/simple_skin.gltf"})
    if (fs::exists(assimp / name)) out.push_back({fs::path(name).filename().string(), bytesOf(assimp / name)});
  return out;
}

using Random = std::mt19937;

std::vector<std::byte> damage(std::vector<std::byte> bytes, Random& random) {
  auto below = [&](size_t n) { return size_t(random() % n); };
  if (below(4) == 0) {
    bytes.resize(below(bytes.size()));
    return bytes;
  }
  size_t flips = 1 + below(4);
  for (size_t i = 0; i < flips; ++i) {
    std::byte& target = bytes[below(bytes.size())];
    switch (below(3)) {
      case 0:
        target ^= std::byte(1u << below(8));
        break;
      case 1:
        target = std::byte(below(256));
        break;
      default:  // most effective in JSON
        target = std::byte("0123456789-.eE{}[]\",:"[below(21)]);
        break;
    }
  }
  return bytes;
}

// Returns true if it loads. On failure, the file is kept at the path that gtest prints.
bool survives(const fs::path& path) {
  try {
    const Scene scene = loadGltf(path, {});
    // A file that loads can be played at any time.
    for (double seconds : {-1.0, 0.3, 1e6}) {
      const Pose pose = poseAt(scene, choosePlayback(scene, "", true), seconds);
      instanceTransforms(scene, pose);
      posedMaterials(scene, pose), posedLights(scene, pose), posedCameras(scene, pose);
      for (const Mesh& mesh : scene.meshes) {
        if (!mesh.deformation || pose.empty()) continue;
        const Deformation& d = *mesh.deformation;
        const std::vector<mat4> joints =
            d.skin < 0 ? std::vector<mat4>{mat4(1)} : jointMatrices(scene.rig.skins[size_t(d.skin)], pose);
        const std::vector<float> weights =
            d.weightsNode < 0 ? std::vector<float>() : pose.weights[size_t(d.weightsNode)];
        deform(d, joints, weights);
        deformedBox(reachOf(d), joints, weights);
      }
    }
    return true;
  } catch (const Error& error) {
    EXPECT_TRUE(error.code() == ExitCode::BadInput) << error.what();
  } catch (const std::exception& error) {
    ADD_FAILURE() << "not an Error: " << error.what();
  }
  return false;
}

class Quiet {
 public:
  Quiet() { setQuiet(true); }
  ~Quiet() { setQuiet(false); }
};

TEST(GltfFuzz, AThousandTruncationsAndByteFlips) {
  Quiet quiet;
  TemporaryFolder folder;
  // LATELIGHT_FUZZ_SEED and LATELIGHT_FUZZ_COUNT allow longer runs by hand.
  const char *seed = std::getenv("LATELIGHT_FUZZ_SEED"), *count = std::getenv("LATELIGHT_FUZZ_COUNT");
  Random random(seed ? uint32_t(std::atol(seed)) : 20240229u);
  int files = count ? std::atoi(count) : 1000;
  std::vector<Sample> good = samples();
  for (const Sample& sample : good) {
    writeBytes(folder.path() / sample.name, sample.bytes);
    EXPECT_TRUE(survives(folder.path() / sample.name)) << sample.name << " should be good";
  }
  int loaded = 0;
  for (int i = 0; i < files; ++i) {
    const Sample& sample = good[size_t(i) % good.size()];
    fs::path path = folder.path() / sample.name;
    writeBytes(path, damage(sample.bytes, random));
    SCOPED_TRACE(fmt::format("number {} of {}", i, sample.name));
    loaded += survives(path);
  }
  // Some flips have no effect. If all or none had one, the damage would test little.
  EXPECT_GT(loaded, files / 20);
  EXPECT_LT(loaded, files * 9 / 10);
}

// Replaces every value of a valid file by values of other types and sizes.
TEST(GltfFuzz, EveryValueReplaced) {
  Quiet quiet;
  TemporaryFolder folder;
  json root = json::parse(busyFile().embedded());
  json flat = root.flatten();
  const json replacements[] = {-1,  0,   1,       255,  4294967295u,   1e300,
                               0.5, "x", nullptr, true, json::array(), json::object()};
  int loaded = 0, rejected = 0;
  for (const auto& [pointer, value] : flat.items()) {
    for (const json& replacement : replacements) {
      json changed = root;
      changed[json::json_pointer(pointer)] = replacement;
      std::string text = changed.dump();
      writeBytes(folder.path() / "changed.gltf", std::as_bytes(std::span(text)));
      SCOPED_TRACE(fmt::format("{} is {}", pointer, replacement.dump()));
      ++(survives(folder.path() / "changed.gltf") ? loaded : rejected);
    }
  }
  // Most replacements are of a wrong type or out of range, but some are valid.
  EXPECT_GT(rejected, 6 * int(flat.size()));
  EXPECT_GT(loaded, 0);
}

}  // namespace
}  // namespace latelight::scene::test
