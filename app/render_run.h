// `latelight render` in two parts: the request, and a run of it on an existing device, scene and renderer. The command
// creates them for one run; the test of random options shares them among many.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/render_options.h"
#include "app/render_time.h"
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
};
// Checks the options before any expensive work, and fills in options.settings. Throws Error(Usage).
RenderPlan planRender(RenderOptions& options);

// The name of the environment that lights the scene; empty: none does.
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
  RenderTimes times{};  // so far
  std::vector<std::filesystem::path> files{};
  std::vector<render::Picked> picked{};
  bool hasIdManifest = false;  // of a sequence: it is written
};

// Renders, writes and reports everything. Throws Error: SomeFramesFailed, Internal for validation messages, and errors
// of the renderer and of writing.
void renderAll(RenderRun& run);

}  // namespace latelight::app
