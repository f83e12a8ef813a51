// A lighting technique: G-buffer and lights in, lit picture out. One folder each under src/render/lighting, its C++
// beside its shaders; folder NAME defines `TechniqueInfo technique_NAME()`, and that is all the registry needs.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "render/frame.h"

namespace latelight::render {

struct TechniqueInfo {
  std::string name;         // filled in by the registry: the folder's, with - for _
  const char* description;  // one line
  bool forward = false;     // draws the scene itself after the depth pass: no geometry pass, no layout
  // Adds the passes that leave the lit picture in gbuffer.light, alpha 1 where a surface is. A deferred technique finds
  // emitted radiance and ambient occlusion there; a forward one finds no targets, and nothing in it. Every technique
  // shades with shared/shade.h over the same lights, so all give the same picture. Where the setup counts lights,
  // gbuffer.lightCounts gets them too.
  void (*add)(const FrameContext& f, const Gbuffer& gbuffer);
};

std::span<const TechniqueInfo> techniques();
const TechniqueInfo& findTechnique(std::string_view name);  // throws Error(Usage) that lists them

}  // namespace latelight::render
