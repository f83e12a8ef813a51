// A lighting technique: G-buffer and lights in, lit picture out. One folder each under src/render/lighting, its C++
// beside its shaders; folder NAME defines `TechniqueInfo technique_NAME()`, and that is all the registry needs.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "render/frame.h"

namespace latelight::render {

class LightingTechnique {
 public:
  virtual ~LightingTechnique() = default;
  // Adds the passes that turn gbuffer.light from emitted radiance and ambient occlusion into the lit picture, alpha 1
  // where a surface is. Every technique shades with shared/shade.h over the same lights, so all give the same picture.
  virtual void add(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer) const = 0;
};

struct TechniqueInfo {
  std::string name;         // filled in by the registry: the folder's, with - for _
  const char* description;  // one line
  std::unique_ptr<LightingTechnique> (*make)(vk::Device& device, const FrameSetup& setup);
};

std::span<const TechniqueInfo> techniques();
const TechniqueInfo& findTechnique(std::string_view name);  // throws Error(Usage) that lists them

}  // namespace latelight::render
