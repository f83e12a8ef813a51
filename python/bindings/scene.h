// A scene as Python holds it: any thread may call it, and none holds the interpreter's lock while it waits or works.
#pragma once

#include <latelight/latelight.h>
#include <nanobind/nanobind.h>

#include <mutex>
#include <shared_mutex>

namespace latelight::python {

class SharedScene {
 public:
  explicit SharedScene(Scene&& scene) : scene_(std::move(scene)) {}

  // `work` takes the scene: several readers at once, of which renderers are some, or one that edits.
  template <typename Work>
  auto read(Work work) const {
    const nanobind::gil_scoped_release others;
    const std::shared_lock lock(busy_);
    return work(static_cast<const Scene&>(scene_));
  }
  template <typename Work>
  auto edit(Work work) {
    const nanobind::gil_scoped_release others;
    const std::unique_lock lock(busy_);
    return work(scene_);
  }

 private:
  Scene scene_;
  mutable std::shared_mutex busy_;
};

}  // namespace latelight::python
