// Times of the device, what is compared in turn in one run: `latelight bench`.
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
  uint32_t frames = 16;                 // of each measurement, after those that warm up
  uint64_t mostTriangles = 10'000'000;  // rows of `raster` with more are left out
  double budget = 10;                   // seconds: rows of `lights` that would take longer are left out
};

// Random triangles at 2048x2048, until the depth of each pixel is known: by number and size.
Table benchRaster(vk::Device& device, const BenchOptions& options);

// A frame of a scene to its finished picture, left on the device, pass by pass.
Table benchFrame(render::Renderer& renderer, const scene::Camera& camera, const render::Moment& moment,
                 const render::Settings& settings, const Ceilings& ceilings, const BenchOptions& options);

// Many views at once, all around: from inside a scene by turning, from outside by going around it; until their results
// are in the device's memory.
Table benchViews(render::Renderer& renderer, const scene::Scene& scene, const scene::Camera& camera,
                 const render::Poses& poses, const render::Settings& settings, uint32_t count,
                 const BenchOptions& options);

// Lighting by every technique in compute, over numbers of lights: a scene after the other, with ever more of them.
class LightsBench {
 public:
  LightsBench(const Ceilings& ceilings, const BenchOptions& options);
  void add(render::Renderer& renderer, const scene::Camera& camera, const render::Moment& moment,
           const render::Settings& settings, uint64_t lights);
  const Table& table() const { return table_; }
  const Ceilings& ceilings() const { return ceilings_; }

 private:
  bool goesOn(const render::TechniqueInfo& technique, uint64_t lights) const;

  Ceilings ceilings_;
  BenchOptions options_;
  std::map<const render::TechniqueInfo*, SweepLine> lines_;  // of milliseconds
  Table table_;
};

// Lighting by lights made up in registers, for each type of light and each way to shade, beside the technique of the
// settings with the scene's own lights.
Table benchShade(render::Renderer& renderer, const scene::Camera& camera, const render::Moment& moment,
                 const render::Settings& settings, const Ceilings& ceilings, const BenchOptions& options);

}  // namespace latelight::study
