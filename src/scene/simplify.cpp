// Simplifies meshes by vertex clustering, and searches for the fraction that produces the requested number of
// triangles.
#include "scene/simplify.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <limits>

#include "base/parallel.h"

namespace latelight::scene {

namespace {

using Indices = std::vector<uint32_t>;

// Simplifies to at most the fraction `share` of the mesh's triangles, and at least one.
Indices coarser(const Mesh& mesh, const Indices& fine, double share) {
  const size_t indexCount = 3 * std::max<size_t>(1, static_cast<size_t>(share * static_cast<double>(fine.size() / 3)));
  if (indexCount >= fine.size()) return fine;
  Indices coarse(fine.size());
  coarse.resize(meshopt_simplifySloppy(coarse.data(), fine.data(), fine.size(), &mesh.positions.front().x,
                                       mesh.positions.size(), sizeof(vec3), indexCount,
                                       std::numeric_limits<float>::max(), nullptr));
  if (coarse.empty()) coarse.assign(fine.begin(), fine.begin() + 3);
  return coarse;
}

}  // namespace

void simplify(Scene& scene, uint64_t triangles) {
  if (scene.triangleCount() <= triangles) return;
  std::vector<Indices> fine;
  for (const Mesh& mesh : scene.meshes) fine.push_back(mesh.indices);
  // Vertex clustering produces fewer triangles than requested, by a factor that can only be determined by trial.
  double share = static_cast<double>(triangles) / static_cast<double>(scene.triangleCount());
  constexpr int kTries = 6;
  for (int i = 0; i < kTries; ++i) {
    parallelFor(fine.size(), 1, [&](size_t begin, size_t end) {
      for (size_t m = begin; m < end; ++m) scene.meshes[m].indices = coarser(scene.meshes[m], fine[m], share);
    });
    const double reached = static_cast<double>(scene.triangleCount()) / static_cast<double>(triangles);
    if (reached > 0.95 && reached < 1.05) return;
    share = std::min(share / reached, 1.0);
  }
}

}  // namespace latelight::scene
