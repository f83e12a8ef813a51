// Environments (image-based lighting) in device memory, as render/glsl/environment.glsl reads them.
#pragma once

#include <span>
#include <vector>

#include "scene/environment/environment.h"
#include "vk/commands.h"
#include "vk/resources.h"

namespace latelight::render {

class GpuEnvironment {
 public:
  // If `environment` is null, there is no environment light: the maps are black.
  GpuEnvironment(vk::Device& device, const scene::Environment* environment);
  // Each environment is a layer of the maps, in this order. There is at least one.
  GpuEnvironment(vk::Device& device, std::span<const scene::Environment* const> environments);

  uint32_t count() const { return static_cast<uint32_t>(radiance_.size()); }
  uint32_t levels() const { return levels_; }                              // of each environment's specular map
  uint32_t map(uint32_t environment) const { return maps_[environment]; }  // FrameConstants::environmentMap
  uint32_t kind() const;  // kEnvironmentOneType or kEnvironmentTwoTypes
  // Returns the prefiltered specular maps, the diffuse maps, the split-sum table, the table of lobes, and both maps
  // with floats if the first have halves: the first bindings of lit_maps.h.
  std::vector<vk::BoundImage> bindings() const;
  // Returns a placeholder for an array of maps that a shader does not read, because every binding requires an image.
  vk::BoundImage nothing() const { return {specular_.arrayView(), clampSampler_.get()}; }
  vk::BoundImage radiance(uint32_t environment = 0) const {  // for backgrounds
    return {radiance_[environment].view(), equirectangularSampler_.get()};
  }

 private:
  void uploadMaps(vk::Device& device, vk::Uploader& uploader, std::span<const scene::Environment* const> environments);

  vk::Image specular_, diffuse_, table_, lobes_;
  vk::Image specularFloats_, diffuseFloats_;  // empty if all environments have the same type
  std::vector<vk::Image> radiance_;
  std::vector<uint32_t> maps_;
  uint32_t levels_ = 0;
  vk::Handle<VkSampler> clampSampler_, equirectangularSampler_;
};

}  // namespace latelight::render
