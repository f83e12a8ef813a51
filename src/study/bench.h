// Times of the device, hardware and compute in turn in one run: `latelight bench`.
#pragma once

#include <cstdint>

#include "render/renderer.h"
#include "study/table.h"
#include "vk/device.h"

namespace latelight::study {

struct BenchOptions {
  uint32_t frames = 16;                 // of each measurement; one more warms up
  uint64_t mostTriangles = 10'000'000;  // rows of `raster` with more are left out
};

// Random triangles at 2048x2048, until the depth of each pixel is known: by number and size.
Table benchRaster(vk::Device& device, const BenchOptions& options);

// A frame of a scene to its finished picture, left on the device, pass by pass.
Table benchFrame(render::Renderer& renderer, const scene::Camera& camera, const render::Moment& moment,
                 const render::Settings& settings, const BenchOptions& options);

// Many views at once, turned about the camera's eye, until their results are in the device's memory.
Table benchViews(render::Renderer& renderer, const scene::Camera& camera, const render::Poses& poses,
                 const render::Settings& settings, uint32_t count, const BenchOptions& options);

}  // namespace latelight::study
