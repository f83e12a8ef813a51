// The device's own G-buffer on the host: every target before lighting, and the lit picture after it.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "render/gbuffer/geometry_pass.h"
#include "render/gbuffer/layout.h"
#include "render/lighting/technique.h"
#include "render/support.h"
#include "render/visibility/hardware.h"

namespace latelight::render::test {

// What is left of a value that is stored in the format: rounded to nearest and decoded.
TargetValue storedValue(VkFormat format, const TargetValue& value);

struct LightSettings {
  float exposure = 1;  // linear factor
  float environmentIntensity = 0, environmentRotation = 0;
  uint32_t firstLight = 0, lightCount = 0;  // of the scene's lights, those that shine
};

// One view of a G-buffer.
struct ReadGbuffer {
  const Layout* layout;
  uint32_t normalEncoding, normalSpace, positionMethod;
  shared::View view;
  uint32_t width, height;
  std::vector<std::vector<TargetValue>> targets;  // one a target of the layout; one a pixel
  std::vector<float> depth;                       // device depth, 0: background
  std::vector<shared::vec4> before, after;        // the light accumulation target, before and after lighting

  // The surface at a pixel that is not background.
  shared::Surface surface(size_t pixel) const;
};

// Scene and environment in device memory, drawn with any layout, encoding, technique and shading.
class GbufferReader {
 public:
  GbufferReader(vk::Device& device, const scene::Scene& scene, const scene::Environment* environment);
  ReadGbuffer read(const FrameSetup& setup, const scene::Camera& camera, uint32_t width, uint32_t height,
                   const LightSettings& light = {});

 private:
  vk::Buffer upload(const char* name, const void* data, size_t bytes);
  const GeometryPass& geometry(const FrameSetup& setup);
  const LightingTechnique& lighting(const FrameSetup& setup);

  vk::Device& device_;
  std::vector<scene::Light> lights_;  // the scene's
  GpuScene scene_;
  GpuEnvironment environment_;
  graph::Executor executor_;
  DepthPass depth_;
  std::map<std::tuple<const Layout*, uint32_t, uint32_t>, std::unique_ptr<GeometryPass>> geometries_;
  std::map<std::tuple<const Layout*, uint32_t, const TechniqueInfo*, uint32_t, uint32_t, uint32_t>,
           std::unique_ptr<LightingTechnique>>
      techniques_;
};

}  // namespace latelight::render::test
