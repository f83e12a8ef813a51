// glTF files as a whole: loading, and playing what was loaded. Mutations know the format: they change the values,
// arrays and members of the JSON by the grammar in gltf_grammar.h, so that most inputs pass the first checks, and now
// and then the bytes of the binary chunk.
#include <algorithm>
#include <optional>
#include <random>
#include <vector>

#include "fuzz/fuzz.h"
#include "fuzz/gltf_grammar.h"
#include "scene/gltf/load.h"

using namespace latelight;

extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t maxSize);

namespace {

void play(const scene::Scene& scene, double seconds) {
  const scene::Pose pose = poseAt(scene, choosePlayback(scene, "", true), seconds);
  instanceTransforms(scene, pose);
  posedMaterials(scene, pose), posedLights(scene, pose), posedCameras(scene, pose);
  for (const scene::Mesh& mesh : scene.meshes) {
    if (!mesh.deformation || pose.empty()) continue;
    const scene::Deformation& d = *mesh.deformation;
    const std::vector<glm::mat4> joints =
        d.skin < 0 ? std::vector<glm::mat4>{glm::mat4(1)} : jointMatrices(scene.rig.skins[size_t(d.skin)], pose);
    const std::vector<float> weights = d.weightsNode < 0 ? std::vector<float>() : pose.weights[size_t(d.weightsNode)];
    deform(d, joints, weights);
    deformedBox(reachOf(d), joints, weights);
  }
}

// Every index of a loaded scene is within the array to which it refers.
void checkIndices(const scene::Scene& scene) {
  for (const scene::Mesh& mesh : scene.meshes)
    for (const uint32_t index : mesh.indices)
      if (index >= mesh.positions.size()) fuzz::report("an index beyond the vertices");
  for (const scene::Instance& instance : scene.instances)
    if (instance.mesh >= scene.meshes.size() || instance.material >= scene.materials.size())
      fuzz::report("an instance of no mesh or material");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  fuzz::start();
  const std::filesystem::path path = fuzz::writeInput("scene.glb", fuzz::bytesOf(data, size));
  fuzz::expectErrors({ExitCode::BadInput}, [&] {
    const scene::Scene scene = scene::loadGltf(path, {});
    checkIndices(scene);
    for (const double seconds : {-1.0, 0.3, 1e6}) play(scene, seconds);
  });
  return 0;
}

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t maxSize, unsigned int number) {
  std::minstd_rand random(number);
  std::optional<fuzz::Glb> glb = random() % 16 == 0 ? std::nullopt : fuzz::readGlb({data, size});
  if (!glb) return LLVMFuzzerMutate(data, size, maxSize);
  if (random() % 8 == 0 && !glb->binary.empty()) {
    LLVMFuzzerMutate(glb->binary.data(), glb->binary.size(), glb->binary.size());
  } else {
    fuzz::GltfMutator mutator(glb->root, random);
    for (unsigned int count = 1 + random() % 3; count > 0; --count) mutator.mutate();
  }
  const std::vector<uint8_t> written = fuzz::writeGlb(*glb);
  if (written.size() > maxSize) return LLVMFuzzerMutate(data, size, maxSize);
  std::ranges::copy(written, data);
  return written.size();
}
