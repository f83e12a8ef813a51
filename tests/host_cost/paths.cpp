// Ten paths of the host whose cost is watched. Valgrind counts the instructions of each (tests/host_cost/check), which
// depend on neither the load nor the clock of the machine. Alone, the program prints seconds, for profiling.
//
//   host_paths --inputs FOLDER   write the files that the paths read
//   host_paths FOLDER            run each path once
#include <fmt/core.h>
#include <valgrind/callgrind.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>

#include "base/parallel.h"
#include "graph/graph.h"
#include "models/models.h"
#include "output/png.h"
#include "render/rays/bvh.h"
#include "scene/animation.h"
#include "scene/clusters.h"
#include "scene/edit.h"
#include "scene/environment/picture_io.h"
#include "scene/environment/tree.h"
#include "scene/load/load.h"

namespace latelight {
namespace {

using Work = std::function<void()>;

// A result that the compiler must compute.
volatile size_t sink;

void writeBytes(const std::filesystem::path& path, const models::Bytes& bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!file.flush()) throw std::runtime_error("can't write " + path.string());
}

// A wavy sheet of 2 * (side - 1)^2 triangles with texture coordinates and normals.
std::string wavyObj(int side) {
  std::string text;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      text += fmt::format("v {:.4f} {:.4f} {:.4f}\nvt {:.4f} {:.4f}\nvn 0 0 1\n", x * 0.1, y * 0.1,
                          std::sin(x * 0.3) * std::cos(y * 0.2), x / double(side), y / double(side));
  for (int y = 0; y + 1 < side; ++y)
    for (int x = 0; x + 1 < side; ++x) {
      const int a = y * side + x + 1, b = a + 1, c = b + side, d = a + side;
      text += fmt::format("f {0}/{0}/{0} {1}/{1}/{1} {2}/{2}/{2} {3}/{3}/{3}\n", a, b, c, d);
    }
  return text;
}

void writeInputs(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  writeBytes(folder / "textured.glb", models::texturedModel());
  writeBytes(folder / "intricate.glb", models::intricateModel());
  writeBytes(folder / "skinned.glb", models::skinnedModel());
  writeBytes(folder / "sky.hdr", models::radiancePanorama(256, 128));
  const std::string obj = wavyObj(60);
  writeBytes(folder / "wavy.obj", {reinterpret_cast<const std::byte*>(obj.data()),
                                   reinterpret_cast<const std::byte*>(obj.data()) + obj.size()});
}

// --- the paths: each prepares what it needs and returns the work that is counted
// --------------------------------------

Work loadFile(const std::filesystem::path& file) {
  return [file] { sink = scene::load(file).instances.size(); };
}

Work environmentTree(const std::filesystem::path& file) {
  return [file] {
    const scene::EnvironmentTree tree(scene::readPicture(file));
    sink = sizeof(tree);
  };
}

Work clusters(const std::filesystem::path& obj) {
  auto scene = std::make_shared<scene::Scene>(scene::load(obj));
  return [scene] { sink = scene::clustersOf(scene->meshes.front()).clusters.size(); };
}

Work bvh(const std::filesystem::path&) {
  std::vector<render::Box> boxes(6000);
  uint32_t state = 1;
  const auto next = [&] { return static_cast<float>((state = state * 1664525u + 1013904223u) >> 8) * 0x1p-24f; };
  for (render::Box& box : boxes) {
    const glm::vec3 low(next(), next(), next());
    box.add(low);
    box.add(low + 0.01f * glm::vec3(next(), next(), next()));
  }
  return [boxes = std::move(boxes)] { sink = render::buildBvh(boxes, 4, 40).nodes.size(); };
}

// A frame of 40 passes: each reads two earlier results and writes one; every fifth leads to no export.
graph::Graph frameGraph() {
  graph::Graph graph;
  std::vector<graph::ImageId> images;
  std::vector<graph::BufferId> buffers;
  for (int i = 0; i < 40; ++i) {
    images.push_back(graph.create(
        vk::ImageDesc{.format = VK_FORMAT_R16G16B16A16_SFLOAT, .width = 64, .height = 64, .name = "image"}));
    buffers.push_back(graph.create(vk::BufferDesc{.size = 4096, .name = "buffer"}));
    std::vector<graph::Access> accesses{{images.back(), graph::Use::StorageWrite},
                                        {buffers.back(), graph::Use::StorageWrite}};
    for (const int back : {1, 3})
      if (i >= back) {
        accesses.emplace_back(images[i - back], graph::Use::SampledCompute);
        accesses.emplace_back(buffers[i - back], graph::Use::StorageRead);
      }
    graph.pass(graph::Stage::Post, fmt::format("pass {}", i), std::move(accesses), {});
  }
  for (int i = 39; i >= 0; i -= 5) graph.exports(images[i], graph::Use::CopySource);
  return graph;
}

Work compileGraphs(const std::filesystem::path&) {
  return [] {
    for (int i = 0; i < 20; ++i) sink = frameGraph().compile().steps.size();
  };
}

Work poses(const std::filesystem::path& file) {
  auto scene = std::make_shared<scene::Scene>(scene::load(file));
  return [scene] {
    const scene::Playback playback = scene::choosePlayback(*scene, "all", true);
    for (int i = 0; i < 20; ++i) {
      const scene::Pose pose = scene::poseAt(*scene, playback, i * 0.05);
      for (const scene::Mesh& mesh : scene->meshes)
        if (mesh.deformation && mesh.deformation->skin >= 0)
          sink =
              scene::deform(*mesh.deformation, scene::jointMatrices(scene->rig.skins[mesh.deformation->skin], pose), {})
                  .positions.size();
    }
  };
}

Work edits(const std::filesystem::path&) {
  auto scene = std::make_shared<scene::Scene>(scene::load("builtin:boxes"));
  return [scene] {
    for (int i = 0; i < 1000; ++i) {
      const uint32_t added = scene::addInstance(*scene, 0, 0, glm::dmat4(1), "added");
      scene::setTransform(*scene, added, glm::translate(glm::dmat4(1), glm::dvec3(i, 0, 0)));
      if (i % 2) scene::removeInstance(*scene, added);
    }
    sink = scene->instances.size();
  };
}

Work png(const std::filesystem::path&) {
  output::Picture picture{.width = 256, .height = 192, .rgba = {}};
  for (uint32_t i = 0; i < picture.width * picture.height; ++i) {
    const uint32_t x = i % picture.width, y = i / picture.width;
    for (const uint32_t value : {x ^ y, x + y, x * y >> 6, 255u}) picture.rgba.push_back(static_cast<uint8_t>(value));
  }
  return [picture] { sink = output::decodePng(output::encodePng(picture), "picture").channels.size(); };
}

struct Path {
  const char* name;
  Work (*prepare)(const std::filesystem::path& file);
  const char* file;
};
constexpr Path kPaths[] = {
    {"load-gltf", loadFile, "textured.glb"},
    {"load-compressed-gltf", loadFile, "intricate.glb"},
    {"load-obj", loadFile, "wavy.obj"},
    {"environment-tree", environmentTree, "sky.hdr"},
    {"clusters", clusters, "wavy.obj"},
    {"bvh", bvh, ""},
    {"compile-graph", compileGraphs, ""},
    {"poses", poses, "skinned.glb"},
    {"edits", edits, ""},
    {"png", png, ""},
};

void runPaths(const std::filesystem::path& folder) {
  const SerialScope serial;  // counts must not depend on how threads share work
  for (const Path& path : kPaths) {
    const Work work = path.prepare(folder / path.file);
    const auto start = std::chrono::steady_clock::now();
    CALLGRIND_ZERO_STATS;
    work();
    CALLGRIND_DUMP_STATS_AT(path.name);
    fmt::print("{} {:.6f}\n", path.name,
               std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
}

}  // namespace
}  // namespace latelight

int main(int count, char** arguments) {
  try {
    if (count == 3 && !std::strcmp(arguments[1], "--inputs"))
      latelight::writeInputs(arguments[2]);
    else if (count == 2)
      latelight::runPaths(arguments[1]);
    else
      throw std::runtime_error("usage: host_paths [--inputs] FOLDER");
  } catch (const std::exception& error) {
    fmt::print(stderr, "host_paths: {}\n", error.what());
    return 1;
  }
}
