// `latelight report`: a scene in every layout and by every technique, on one page.
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
  const render::Moment& moment;
  render::Settings settings;  // the layouts are compared with its technique, and the techniques with its layout
  // The scene and the options that were given, as `latelight render` takes them, but layout, technique, raster and what
  // leaves.
  std::vector<std::string> given;
  std::string command;     // the line that makes this page
  study::Options normals;  // of the study of normal encodings
  uint32_t runs;           // frames of which each time is the median
};

// What was given, but for what would mean nothing to this layout, and be refused.
std::vector<std::string> givenFor(const Subject& subject, const render::Layout& layout);

// Whether the device can light this layout, and the settings with which it is: another technique and raster where those
// of the page can't. And those of a technique, with another layout in turn.
bool canLight(const Subject& subject, const render::Layout& layout);
render::Settings settingsFor(const Subject& subject, const render::Layout& layout);
render::Settings settingsFor(const Subject& subject, const render::TechniqueInfo& technique);

std::string scenePage(const Subject& subject);

}  // namespace latelight::report
