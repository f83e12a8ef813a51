// `latelight report`: compares a scene in every layout and by every technique on one page.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "render/gbuffer/layout.h"
#include "render/submit/renderer.h"
#include "study/study.h"
#include "vk/device.h"

namespace latelight::report {

struct Subject {
  vk::Device& device;
  render::Renderer& renderer;
  const scene::Scene& scene;
  const scene::Camera& camera;
  const render::SceneState& moment;
  render::Settings settings;  // the layouts are compared with its technique, and the techniques with its layout
  // The scene and the options of the user as words of `latelight render`, without layout, technique, raster and
  // outputs.
  std::vector<std::string> given;
  std::string command;     // the command line that creates this page
  study::Options normals;  // options for the study of normal encodings
  uint32_t runs;           // frames per time, which is their median
  size_t maxBytes;         // limit of the page
};

// Returns `given` without the options that this layout would reject as meaningless.
std::vector<std::string> optionsFor(const Subject& subject, const render::Layout& layout);

// canLight() returns true if the device can light this layout, and if the device and the page's options support the
// technique. settingsFor() returns the settings for a layout; they use another technique and raster if those of the
// page cannot light it. For a technique, they use another layout if required.
bool canLight(const Subject& subject, const render::Layout& layout);
bool canLight(const Subject& subject, const render::TechniqueInfo& technique);
render::Settings settingsFor(const Subject& subject, const render::Layout& layout);
render::Settings settingsFor(const Subject& subject, const render::TechniqueInfo& technique);

// Throws Error(Usage) as soon as the page exceeds its limit.
std::string scenePage(const Subject& subject);

}  // namespace latelight::report
