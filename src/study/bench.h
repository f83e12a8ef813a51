// `latelight bench`: device times of alternatives, measured in alternation within one run.
#pragma once

#include <cstdint>
#include <map>

#include "render/submit/renderer.h"
#include "study/ceilings.h"
#include "study/sweep.h"
#include "study/table.h"
#include "vk/device.h"

namespace latelight::study {

struct BenchOptions {
  uint32_t frames = 16;                // per measurement, after the warm-up
  uint64_t maxTriangles = 10'000'000;  // rows of `raster` with more triangles are skipped
  double budget = 10;                  // seconds: rows of `lights` that are estimated to exceed it are skipped
};

// Returns the number of triangles of the smallest row of benchRaster().
uint64_t minRasterTriangles();

// Measures random triangles at 2048x2048, by count and size, until the depth of each pixel is known.
Table benchRaster(vk::Device& device, const BenchOptions& options);

// Measures a frame of a scene pass by pass up to its finished image, which stays on the device, with each raster that
// the settings and the camera allow (render::possibleRasters()).
Table benchFrame(const vk::Device& device, render::Renderer& renderer, const scene::Camera& camera,
                 const render::SceneState& moment, const render::Settings& settings, const Ceilings& ceilings,
                 const BenchOptions& options);

// Measures many views at once until their results are in device memory. From inside a scene the camera turns in place;
// from outside it orbits the scene.
Table benchViews(const vk::Device& device, render::Renderer& renderer, const scene::Scene& scene,
                 const scene::Camera& camera, const render::Poses& poses, const render::Settings& settings,
                 uint32_t count, const BenchOptions& options);

// As benchViews(), with a world per view, in which every instance is moved a little. Each call has other transforms and
// poses than the last one, as arrays on the device if shaders place the worlds (Renderer::placesWorlds()). Otherwise
// they are in host memory, and their conversion and upload are included.
Table benchWorlds(vk::Device& device, render::Renderer& renderer, const scene::Scene& scene,
                  const scene::Camera& camera, const render::Poses& poses, const render::Settings& settings,
                  uint32_t count, const BenchOptions& options);

// Measures rays through the scene on the device: `count` rays through the pixels of the camera, from the surfaces that
// these hit in random directions, and to lights; and the time on the host of Renderer::cast() for up to a million rays
// in all directions. Also reports the size of the BVHs and the time to build them.
Table benchRays(render::Renderer& renderer, const scene::Camera& camera, const render::SceneState& moment,
                const render::Settings& settings, uint32_t count, const BenchOptions& options);

// Measures lighting by every technique in compute over numbers of lights. The caller adds one scene after another, with
// increasing numbers of lights.
class LightsBench {
 public:
  LightsBench(const Ceilings& ceilings, const BenchOptions& options);
  void add(render::Renderer& renderer, const scene::Camera& camera, const render::SceneState& moment,
           const render::Settings& settings, uint64_t lights);
  const Table& table() const { return table_; }
  const Ceilings& ceilings() const { return ceilings_; }

 private:
  bool shouldContinue(const render::TechniqueInfo& technique, uint64_t lights) const;

  Ceilings ceilings_;
  BenchOptions options_;
  std::map<const render::TechniqueInfo*, SweepLine> lines_;  // milliseconds
  Table table_;
};

// Measures lighting by synthetic lights that are generated in registers, for each type of light and each shading model,
// next to the technique of the settings with the scene's own lights.
Table benchShade(render::Renderer& renderer, const scene::Camera& camera, const render::SceneState& moment,
                 const render::Settings& settings, const Ceilings& ceilings, const BenchOptions& options);

}  // namespace latelight::study
