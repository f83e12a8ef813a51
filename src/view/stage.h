// A scene on a device, with its environment: what a viewing session makes pictures of.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/submit/picking.h"
#include "render/submit/renderer.h"
#include "scene/environment/environment.h"
#include "view/choice.h"
#include "view/file_watch.h"

namespace latelight::view {

// Which of the scene's cameras looks; or, where steered, from where.
struct CameraChoice {
  std::string camera;  // a name or a number; empty: the first, or one that shows all
  struct Placed {
    glm::dvec3 eye, target;  // the scene file's frame
    double fov;              // degrees
  };
  std::optional<Placed> placed;
};

// The same as a command line says it.
std::vector<std::string> wordsOf(const CameraChoice& choice);

class Stage {
 public:
  // Throws Error where scene or device can't be.
  Stage(const std::string& source, const scene::LoadOptions& load, const vk::DeviceOptions& device);

  scene::Scene& scene() { return *scene_; }
  const scene::Scene& scene() const { return *scene_; }
  vk::Device& device();
  // Another scene, or the same one again; throws Error and keeps what there was.
  void open(const std::string& source, const scene::LoadOptions& load);
  bool filesChanged() { return watch_.changed(); }
  bool shadersChanged() { return shaderWatch_.changed(); }

  // The scene's cameras at the settings' time.
  scene::Camera camera(const CameraChoice& choice, const render::Settings& settings) const;
  // What --hdri would be given, or what was given here; the renderer is made anew where the environment is another one.
  void light(const std::string& asked);
  // Reads its file again; throws Error and keeps what there was.
  void lightAgain();
  bool environmentChanged() { return environmentWatch_.changed(); }
  void give(scene::Environment environment) { given_ = std::move(environment), environmentName_.reset(); }
  // As `latelight render` does it. `ids`: the output id of the same pixels, where it is wanted.
  struct Result {
    output::Picture picture;
    std::optional<output::AovImage> ids;
  };
  Result render(const ChosenSettings& chosen, const CameraChoice& camera, bool ids);
  render::Picked pick(const render::Settings& settings, const CameraChoice& camera, glm::uvec2 pixel);
  const std::vector<graph::PassTime>& passes() const { return passes_; }

  // After an error that may have taken the device with it, and for other shaders: the next picture begins with a new
  // one.
  void dropDevice();

 private:
  void loadEnvironment(const std::string& name);
  render::Renderer& renderer();
  render::SceneState momentOf(const CameraChoice& camera, const render::Settings& settings) const;
  render::Settings prepared(const render::Settings& settings);  // without `auto`

  vk::DeviceOptions deviceOptions_;
  FileWatch watch_, environmentWatch_, shaderWatch_;
  std::unique_ptr<vk::Device> device_;
  std::unique_ptr<scene::Scene> scene_;
  std::optional<std::string> environmentName_;
  std::optional<scene::Environment> environment_, given_;
  std::unique_ptr<render::Renderer> renderer_;
  std::vector<graph::PassTime> passes_;
};

}  // namespace latelight::view
