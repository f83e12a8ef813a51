// A lighting technique as the settings know it: its name, its requirements, and the function that adds its passes. The
// passes themselves are in modules above.
#pragma once

#include <functional>
#include <string>

namespace latelight::render {

struct FrameContext;
struct Gbuffer;
struct LightLists;

struct TechniqueInfo {
  std::string name;         // set by the registry: the folder's name, with - for _
  const char* description;  // one line
  bool forward = false;     // draws the scene itself after the depth pass: no geometry pass, no layout
  bool draws = false;       // requires the graphics pipeline; every forward technique does
  bool traces = false;      // traces paths: its picture includes light between surfaces, unlike those of all others
  // Adds the passes that write the lit picture to gbuffer.light, with alpha 1 at pixels with a surface. For a deferred
  // technique, gbuffer.light initially contains emitted radiance and ambient occlusion; for a forward technique it is
  // empty, and gbuffer.targets is empty too. Every technique shades the same lights with shared/shade.h, so all produce
  // the same picture. If the setup counts lights, the pass writes the counts to gbuffer.lightCounts. Compute shaders of
  // a deferred technique declare the variants layout, visible, multisampled and sample-layers (docs/extending.md,
  // "Shader variants") and call bindSurfaces() first. Returns the light lists of the visible surfaces for later passes,
  // or empty ones.
  std::function<LightLists(const FrameContext& f, const Gbuffer& gbuffer)> add;
};

}  // namespace latelight::render
