// A lighting technique: G-buffer and lights in, lit picture out. One folder each under src/render/lighting, with its
// C++ and its shaders; folder NAME defines `TechniqueInfo technique_NAME()`, and that is all the registry needs.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "render/frame.h"

namespace latelight::render {

struct TechniqueInfo {
  std::string name;         // filled in by the registry: the folder's, with - for _
  const char* description;  // one line
  bool forward = false;     // draws the scene itself after the depth pass: no geometry pass, no layout
  bool draws = false;       // takes the graphics pipeline; every forward one does
  // Adds the passes that write the lit picture to gbuffer.light, with alpha 1 where there is a surface. A deferred
  // technique finds emitted radiance and ambient occlusion there; for a forward one it is empty, and there are no
  // targets. Every technique shades with shared/shade.h over the same lights, so all give the same picture. If the
  // setup counts lights, the counts go to gbuffer.lightCounts. Compute shaders of a deferred technique declare the
  // variants layout, visible, multisampled and layered (docs/extending.md, "Shader variants") and call showSurfaces()
  // first.
  std::function<void(const FrameContext& f, Gbuffer& gbuffer)> add;
};

std::span<const TechniqueInfo> techniques();
const TechniqueInfo& findTechnique(std::string_view name);  // throws Error(Usage) that lists them
std::string techniquesThatCompute();                        // "a, b or c": those that take no graphics pipeline

}  // namespace latelight::render
