// `latelight render` in two parts: planning the request, and running it on an existing device, scene and renderer. The
// command creates these for one run; the test of random options shares them between many runs.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/render_options.h"
#include "app/render_time.h"
#include "data/formats/object_labels.h"
#include "output/debug_request.h"
#include "output/files.h"
#include "render/submit/picking.h"
#include "render/submit/renderer.h"
#include "scene/scene.h"
#include "vk/device.h"

namespace latelight::app {

struct RenderPlan {
  std::optional<output::DebugRequest> debug;
  output::OutputRequest request;
  std::optional<data::ObjectLabels> labels;
};
// Checks the options before any expensive work, and fills in options.settings. Throws Error(Usage).
RenderPlan planRender(RenderOptions& options);

// Returns the name of the environment that lights the scene, or an empty text if there is none.
std::string environmentOf(const RenderOptions& options, const scene::Scene& scene);

struct RenderTimes {  // seconds
  double load = 0, upload = 0, render = 0, write = 0, total = 0;
};

// State shared by the frames of one run.
struct RenderRun {
  const RenderOptions& options;
  const RenderPlan& plan;
  const scene::Scene& scene;
  const Timeline& timeline;
  const std::string& environment;  // its name
  vk::Device& device;
  render::Renderer& renderer;
  RenderTimes times{};  // accumulated so far
  std::vector<std::filesystem::path> files{};
  std::vector<render::Picked> picked{};
  render::RenderStatistics statistics{};            // of the last frame
  std::vector<float> exposures{};                   // the metered factor of each frame; empty: none is metered
  bool hasIdManifest = false;                       // the id manifest of a sequence has been written
  std::shared_ptr<const output::IdManifest> ids{};  // of the scene, for labels
};

// Renders, writes and reports everything. Throws Error: SomeFramesFailed, Internal for validation messages, and errors
// of rendering and writing.
void renderAll(RenderRun& run);

}  // namespace latelight::app
