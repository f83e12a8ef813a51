// Implements --raster auto: chooses the raster that suits a device, by measurement.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "render/submit/renderer.h"

namespace latelight::render {

enum class RasterUse {
  Image,           // a process may render only one, so the time to create pipelines counts
  Worlds,          // of calls that repeat, so only the time of a call counts
  DeformedWorlds,  // the same, with other vertices in each call, so that rays have no hierarchies to keep
};

struct RasterChoice {
  Raster raster;    // not Auto
  std::string why;  // a sentence without its period
};

// Returns the raster that `settings.raster` stands for on this device: itself, or the choice of `auto`. If both
// hardware and compute are possible, `auto` chooses the one that finds the depth of 300,000 small triangles sooner.
// This is measured the first time on a device and driver, then kept in the cache folder. Where descriptor indexing is
// not enabled, the choice depends on the scene's triangle count and on `use` instead. Worlds of far more triangles than
// pixels are rendered with rays on CPU devices. Throws Error(NoDevice) if the device supports neither raster.
RasterChoice chooseRaster(vk::Device& device, const Settings& settings, const scene::Scene& scene,
                          RasterUse use = RasterUse::Image);

// Returns the rasters of which frames with these settings and cameras may have any: the one that they always have,
// regardless of `settings.raster`, or the one that this names, or for `auto` hardware and compute. Throws
// Error(NoDevice) if the device supports neither, and Error(Usage) for settings that the cameras do not support.
std::vector<Raster> possibleRasters(const vk::Device& device, const Settings& settings,
                                    std::span<const scene::Camera> cameras);

// Returns the milliseconds of device time until the depth of each pixel is known, for each of `frames` frames of a
// square picture from the scene's first camera. Before, it renders one frame to warm up, and more until `warmUp`
// seconds have passed.
std::vector<double> depthTimes(Renderer& renderer, const scene::Scene& scene, Raster raster, uint32_t size,
                               uint32_t frames, double warmUp = 0);

}  // namespace latelight::render
