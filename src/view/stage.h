// A scene on a device with its environment, from which a viewing session renders pictures.
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

// A camera of the scene, or the pose of an interactive camera.
struct CameraChoice {
  std::string camera;  // scene/camera_selector.h; empty: the first, or one that frames the scene
  struct Placed {
    glm::dvec3 eye, target;  // in the scene file's coordinates
    double fov;              // vertical, in degrees
  };
  std::optional<Placed> placed;
};

// Returns the camera choice as words of a command line.
std::vector<std::string> wordsOf(const CameraChoice& choice);

class Stage {
 public:
  // Throws Error if the scene or the device is not available.
  Stage(const std::string& source, const scene::LoadOptions& load, const vk::DeviceOptions& device);

  scene::Scene& scene() { return *scene_; }
  const scene::Scene& scene() const { return *scene_; }
  vk::Device& device();
  // Opens another scene, or the same one again. On Error, the current scene is kept. If it was the same one,
  // filesChanged() then also watches the files that it refers to now, so that it is opened again once they exist.
  void open(const std::string& source, const scene::LoadOptions& load);
  bool filesChanged() { return watch_.changed(); }
  bool shadersChanged() { return shaderWatch_.changed(); }

  // Returns the camera at the settings' time.
  scene::Camera camera(const CameraChoice& choice, const render::Settings& settings) const;
  // Sets the environment: a value of --hdri, or the name of one passed to give(). If it differs from the current one, a
  // new renderer is created.
  void light(const std::string& asked);
  // Reads the environment's file again. On Error, the current environment is kept.
  void lightAgain();
  bool environmentChanged() { return environmentWatch_.changed(); }
  void give(scene::Environment environment) { given_ = std::move(environment), environmentName_.reset(); }
  // Throws the Error with which render() rejects options that the scene, the camera or the environment (as for light())
  // does not support, without rendering.
  void check(const ChosenSettings& chosen, const CameraChoice& choice, const std::string& environment);
  // Renders a picture as `latelight render` does. If `ids` is set, the result includes the output "id" of the same
  // pixels.
  struct Result {
    output::Picture picture;
    std::optional<output::AovImage> ids;
  };
  // `follows`: the picture follows the last one, so the temporal filter of indirect light continues from it.
  Result render(const ChosenSettings& chosen, const CameraChoice& camera, bool ids, bool follows = false);
  render::Picked pick(const render::Settings& settings, const CameraChoice& camera, glm::uvec2 pixel);
  const std::vector<graph::PassTime>& passes() const { return passes_; }

  // Releases the device, so that the next picture creates a new one. Call this after an error that may have lost the
  // device, and to reload shaders.
  void dropDevice();

 private:
  void loadEnvironment(const std::string& name);
  render::Renderer& renderer();
  render::SceneState momentOf(const CameraChoice& camera, const render::Settings& settings) const;
  void follow(render::SceneState& moment) const;
  render::Settings prepared(const render::Settings& settings);  // with `auto` values resolved

  vk::DeviceOptions deviceOptions_;
  FileWatch watch_, environmentWatch_, shaderWatch_;
  std::unique_ptr<vk::Device> device_;
  std::unique_ptr<scene::Scene> scene_;
  std::optional<std::string> environmentName_;
  std::optional<scene::Environment> environment_, given_;
  std::unique_ptr<render::Renderer> renderer_;
  std::vector<graph::PassTime> passes_;
  // The state that the last picture showed; none before the first.
  struct Shown {
    scene::Camera camera;
    scene::Pose pose;
  };
  std::optional<Shown> shown_;
};

}  // namespace latelight::view
