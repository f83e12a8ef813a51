// A scene for Python. Any thread may call it, and no thread holds the GIL while it waits or works.
#pragma once

#include <latelight/latelight.h>
#include <nanobind/nanobind.h>

#include <memory>
#include <mutex>

#include "edit_lock.h"
#include "interpreter.h"

namespace latelight::python {

class SharedScene {
 public:
  explicit SharedScene(Scene&& scene) : scene_(std::move(scene)) {}

  template <typename Work>
  auto read(Work work) const {
    const WithoutGil others;
    const EditLock::Reader reader(busy_);
    return work(static_cast<const Scene&>(scene_));
  }
  template <typename Work>
  auto edit(Work work) {
    if (busy_.isReadByThisThread())
      throw Error(ExitCode::Usage,
                  "the scene is in use: a signal handler or __del__() that runs while a call reads the scene must not "
                  "edit it");
    const WithoutGil others;
    const std::unique_lock lock(busy_);
    return work(scene_);
  }

 private:
  Scene scene_;
  mutable EditLock busy_;
};

// Adds the morph targets and the skin that the arguments of add_mesh() describe. (scene_animation.cpp)
void deformationOf(nanobind::handle targets, nanobind::handle skin, nanobind::handle joints,
                   nanobind::handle jointWeights, MeshData& mesh);
// Defines the methods that add nodes, skins and animations. (scene_animation.cpp)
void defineAnimation(nanobind::module_& module, nanobind::class_<SharedScene>& type);

// Returns the environment of an array (H, W, 3).
EnvironmentData environmentOf(nanobind::handle value);

}  // namespace latelight::python
