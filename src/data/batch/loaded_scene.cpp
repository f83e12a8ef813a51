#include "data/batch/loaded_scene.h"

#include "base/error.h"
#include "render/session.h"

namespace latelight::data {

LoadedScene::LoadedScene(const Job& job, scene::Scene scene)
    : job_(job), scene_(std::move(scene)), cameras_(camerasOf(job, scene_)) {
  if (!job.variations.is_null()) variations_.emplace(job.variations, scene_, job.seed);
}

const nlohmann::ordered_json& LoadedScene::show(uint32_t variation) {
  if (variations_ && shown_ != variation) drawn_ = variations_->apply(variation);
  shown_ = variation;
  return drawn_;
}

std::string LoadedScene::environment() const {
  if (variations_ && !variations_->environment().empty()) return variations_->environment();
  const bool isSeen = job_.settings.background.kind == render::Background::Environment;
  return render::environmentName(scene_, job_.hdri.empty() && isSeen ? "studio" : job_.hdri);
}

std::unique_ptr<LoadedScene> SceneLoader::load(uint32_t index) {
  std::optional<scene::Scene> scene;
  {
    const std::lock_guard lock(mutex_);
    scene = plan_.takeScene();
  }
  const PlannedScene& planned = plan_.scenes()[index];
  if (!scene) scene = scene::load(planned.source, job_.load);
  auto loaded = std::make_unique<LoadedScene>(job_, std::move(*scene));
  if (loaded->cameras() != planned.cameras.size())
    badInput("'{}' has changed since the job began: run it again with --resume", planned.source);
  return loaded;
}

}  // namespace latelight::data
