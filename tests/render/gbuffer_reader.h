// Reads the device's G-buffer back to the host: every target before lighting, and the lit image after it.
#pragma once

#include <string>
#include <vector>

#include "render/frame_bench.h"
#include "render/gbuffer/layout.h"
#include "render/lighting/technique.h"
#include "render/support.h"

namespace latelight::render::test {

// The value after storage in the format: rounded to nearest and decoded.
TargetValue storedValue(VkFormat format, const TargetValue& value);

struct LightSettings {
  float exposure = 1;  // linear factor
  float environmentIntensity = 0, environmentRotation = 0;
  uint32_t firstLight = 0, lightCount = 0;  // the range of the scene's lights that emit light
};

// One view of a G-buffer.
struct ReadGbuffer {
  const Layout* layout;
  uint32_t normalEncoding, normalSpace, positionMethod;
  shared::View view;
  uint32_t width, height;
  std::vector<std::vector<TargetValue>> targets;  // one vector per target of the layout, one value per pixel
  std::vector<float> depth;                       // device depth; 0 is background
  std::vector<shared::vec4> before, after;        // the light accumulation target, before and after lighting

  // The surface at a pixel, which must not be background.
  shared::Surface surface(size_t pixel) const;
};

// A scene and an environment in device memory, rendered with any layout, encoding, technique and shading.
class GbufferReader {
 public:
  GbufferReader(vk::Device& device, const scene::Scene& scene, const scene::Environment* environment);
  ReadGbuffer read(const FrameConfig& setup, const scene::Camera& camera, uint32_t width, uint32_t height,
                   const LightSettings& light = {});

 private:
  FrameBench frames_;
};

}  // namespace latelight::render::test
