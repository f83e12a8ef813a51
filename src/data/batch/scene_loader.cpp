#include "data/batch/scene_loader.h"

#include "base/error.h"
#include "scene/load/load.h"

namespace latelight::data {

std::unique_ptr<LoadedScene> SceneLoader::load(uint32_t index) {
  std::unique_ptr<LoadedScene> loaded;
  {
    const std::lock_guard lock(mutex_);
    loaded = plan_.takeScene();
  }
  const PlannedScene& planned = plan_.scenes()[index];
  if (!loaded) loaded = std::make_unique<LoadedScene>(job_, scene::load(planned.source, job_.load));
  if (loaded->cameras().size() != planned.cameras.size())
    badInput("'{}' has changed since the job began: run it again with --resume", planned.source);
  return loaded;
}

}  // namespace latelight::data
