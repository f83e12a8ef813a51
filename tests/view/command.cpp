#include "view/command.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <memory>

#include "app/render_run.h"
#include "render/submit/raster_choice.h"
#include "render/submit/session.h"
#include "scene/load/load.h"

namespace latelight::view {

namespace {

std::unique_ptr<vk::Device> shared;

// Static destructors would run too late for the calls that the device's own destructor makes.
class Shutdown : public testing::Environment {
  void TearDown() override { shared.reset(); }
};
[[maybe_unused]] testing::Environment* const shutdown = testing::AddGlobalTestEnvironment(new Shutdown);

vk::Device& device() {
  if (!shared) shared = std::make_unique<vk::Device>(vk::DeviceOptions{.selector = "cpu"});
  return *shared;
}

// As in the command.
void run(std::vector<std::string> arguments) {
  CLI::App command;
  app::RenderOptions o;
  app::addRenderOptions(command, o);
  std::reverse(arguments.begin(), arguments.end());  // in the order that CLI11 expects
  command.parse(arguments);
  const app::RenderPlan plan = app::planRender(o);
  const scene::Scene scene = scene::load(o.scene, {.variant = o.variant, .ids = o.idGrouping});
  const app::Timeline timeline(scene, o);
  const std::string name = app::environmentOf(o, scene);
  const std::optional<scene::Environment> environment = render::loadEnvironment(scene, name);
  o.settings.raster = render::chooseRaster(device(), o.settings, scene).raster;
  render::Renderer renderer(device(), scene, environment ? &*environment : nullptr);
  app::RenderRun run{o, plan, scene, timeline, name, device(), renderer};
  app::renderAll(run);
}

}  // namespace

std::string rendered(const std::vector<std::string>& words, const std::string& file) {
  std::vector<std::string> arguments(words.begin() + 2, words.end());
  arguments.insert(arguments.end(), {"-o", file});
  try {
    run(arguments);
  } catch (const std::exception& error) {
    ADD_FAILURE() << error.what();
  }
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace latelight::view
