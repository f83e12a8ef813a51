// An environment (image-based lighting) in device memory, as render/glsl/environment.glsl reads it.
#pragma once

#include "scene/environment/environment.h"
#include "vk/commands.h"
#include "vk/resources.h"

namespace latelight::render {

class GpuEnvironment {
 public:
  // If `environment` is null, there is no environment light: the maps are black.
  GpuEnvironment(vk::Device& device, const scene::Environment* environment);

  uint32_t levels() const { return specular_.desc().levels; }
  // Returns the prefiltered specular map, the diffuse map, the split-sum table and the table of lobes: the first
  // bindings of lit_maps.h.
  std::vector<vk::BoundImage> bindings() const;
  // Returns a placeholder for an array of maps that a shader does not read, because every binding requires an image.
  vk::BoundImage nothing() const { return {specular_.arrayView(), clampSampler_.get()}; }
  vk::BoundImage radiance() const { return {radiance_.view(), equirectangularSampler_.get()}; }  // for backgrounds

 private:
  vk::Image specular_, diffuse_, table_, lobes_, radiance_;
  vk::Handle<VkSampler> clampSampler_, equirectangularSampler_;
};

}  // namespace latelight::render
