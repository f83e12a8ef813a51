// --raster auto: the raster that suits a device, by measurement.
#pragma once

#include <string>
#include <vector>

#include "render/renderer.h"

namespace latelight::render {

struct RasterChoice {
  Raster raster;    // Hardware or Compute
  std::string why;  // a sentence without its full stop
};

// What `settings.raster` stands for on this device: itself, or the choice of `auto`. That takes what is possible at
// all; of two, the one that finds the depth of 300,000 small triangles sooner. The first time on a device and driver it
// is measured, then kept in the cache folder. On devices without descriptor indexing it depends on how many triangles
// the scene has instead. Throws Error(NoDevice) where the device has neither.
RasterChoice chooseRaster(vk::Device& device, const Settings& settings, const scene::Scene& scene);

// Milliseconds that the device takes until the depth of each pixel is known, in a square picture by the scene's first
// camera: one for each frame, after one that warms up, or as many as take `warmUp` seconds.
std::vector<double> depthTimes(Renderer& renderer, const scene::Scene& scene, Raster raster, uint32_t size,
                               uint32_t frames, double warmUp = 0);

}  // namespace latelight::render
