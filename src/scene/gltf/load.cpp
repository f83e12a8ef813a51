// Loads glTF 2.0 files as scenes (scene::loadGltf). Chapter and section numbers in this folder are those of the glTF
// 2.0 specification (Khronos, 2021).
#include "scene/gltf/load.h"

#include <algorithm>
#include <functional>
#include <new>
#include <numeric>
#include <span>

#include "base/error.h"
#include "base/log.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "scene/gltf/document.h"
#include "scene/gltf/environment.h"
#include "scene/gltf/instances.h"
#include "scene/gltf/material.h"
#include "scene/gltf/mesh.h"
#include "scene/gltf/nodes.h"
#include "scene/ids.h"
#include "scene/scene.h"

namespace latelight::scene {
namespace gltf {
namespace {

struct Job {
  size_t cost;  // the most expensive jobs start first, or one thread would finish last
  std::function<void()> run;
};

void addTextureJobs(const Document& document, const TextureTable& table, Scene& scene, std::vector<Job>& jobs) {
  scene.textures.resize(table.requests().size());
  size_t total = 0;
  for (size_t i = 0; i < table.requests().size(); ++i) {
    const TextureRequest& request = table.requests()[i];
    total += textureBytes(document, request);
    // Decoding time is proportional to encoded bytes rather than pixels: about 40 ns per byte, 1 ns per pixel.
    jobs.push_back({encodedBytes(document, request) * 40,
                    [&texture = scene.textures[i], &document, &request] { texture = makeTexture(document, request); }});
  }
  scene.memory.grow(total, "its textures");
}

void addMeshJobs(const Document& document, const Hierarchy& hierarchy, const std::vector<MeshRequest>& requests,
                 bool morphTargets, Scene& scene, std::vector<Job>& jobs) {
  scene.meshes.resize(requests.size());
  for (size_t i = 0; i < requests.size(); ++i) {
    const MeshRequest& request = requests[i];
    const auto& primitive = document.model.meshes[size_t(request.mesh)].primitives[size_t(request.primitive)];
    jobs.push_back({triangleCount(document, primitive) * 100, [&, i, morphTargets] {
                      scene.meshes[i] = buildMesh(document, hierarchy, requests[i]);
                      if (morphTargets) addMorphable(document, hierarchy, requests[i], scene.meshes[i]);
                    }});
  }
}

void runJobs(const std::vector<Job>& jobs, const std::string& name) {
  std::vector<size_t> order(jobs.size());
  std::iota(order.begin(), order.end(), size_t(0));
  std::ranges::stable_sort(order, std::greater(), [&](size_t i) { return jobs[i].cost; });
  std::vector<std::vector<std::string>> warnings(jobs.size());  // printed in file order
  Progress progress("Loading " + name, jobs.size());
  parallelFor(jobs.size(), 1, [&](size_t begin, size_t end) {
    for (const size_t i : std::span(order).subspan(begin, end - begin)) {
      const WarningCapture capture(warnings[i]);
      jobs[i].run();
      progress.step();
    }
  });
  for (const auto& ofJob : warnings)
    for (const std::string& sentence : ofJob) warn(sentence);
}

// Returns the memory of loaded meshes and instances.
uint64_t geometryBytes(const Scene& scene) {
  uint64_t bytes = scene.instances.size() * sizeof(Instance) + scene.nodes.size() * sizeof(Node) +
                   scene.fileNodes.size() * sizeof(RigNode);
  for (const auto& [node, copies] : scene.fileCopies)
    bytes += (copies.translations.size() + copies.rotations.size() + copies.scales.size()) * sizeof(vec4);
  for (const Mesh& mesh : scene.meshes) bytes += mesh.bytes();
  return bytes;
}

Scene import(const std::filesystem::path& path, const LoadOptions& options, const FileObserver& observer) {
  Document document;
  openDocument(document, path, AllowedFolders(path, options.allowOutside, observer));
  Scene scene;
  scene.name = path.stem().string();
  scene.source = path.string();
  scene.files = {path};
  for (const std::filesystem::path& file : document.beside) scene.files.push_back(path.parent_path() / file);
  int variant = readVariants(document, options.variant, scene);
  Hierarchy hierarchy = readNodes(document, scene);
  readCameras(document, hierarchy, scene);
  readLights(document, hierarchy, scene);
  readRig(document, hierarchy, scene);
  TextureTable textures;
  readMaterials(document, options.textureSlots, textures, scene);
  std::vector<MeshRequest> requests = placeInstances(document, hierarchy, variant, options, scene);
  identifyMaterials(scene);

  std::vector<Job> jobs;
  if (options.textures) readEnvironment(document, scene);
  if (options.textures) addTextureJobs(document, textures, scene, jobs);
  addMeshJobs(document, hierarchy, requests, options.morphTargets, scene, jobs);
  runJobs(jobs, scene.name);
  document.repairs.report();
  document.budget.release();
  scene.memory.grow(geometryBytes(scene), "its meshes");
  return scene;
}

}  // namespace
}  // namespace gltf

Scene loadGltf(const std::filesystem::path& path, const LoadOptions& options, const FileObserver& observer) {
  try {
    return gltf::import(path, options, observer);
  } catch (const Error& error) {
    std::string sentence = error.what();
    if (sentence.find(path.string()) != std::string::npos) throw;
    throw Error(error.code(), fmt::format("{}: {}", path.string(), sentence));
  } catch (const std::bad_alloc&) {
    failWithoutMemory(fmt::format("the scene {}", path.string()));
  }
}

}  // namespace latelight::scene
