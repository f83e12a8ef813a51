#include "data/batch/loaded_scene.h"

#include "render/submit/session.h"

namespace latelight::data {

LoadedScene::LoadedScene(const Job& job, scene::Scene scene)
    : job_(job), scene_(std::move(scene)), cameras_(job, scene_) {
  if (!job.variations.is_null()) variations_.emplace(job.variations, scene_, job.seed);
}

const nlohmann::ordered_json& LoadedScene::show(uint32_t variation) {
  if (variations_ && shown_ != variation) drawn_ = variations_->apply(variation);
  shown_ = variation;
  return drawn_;
}

std::optional<double> LoadedScene::environmentRotation() const {
  return variations_ ? variations_->environmentRotation() : std::nullopt;
}

std::string LoadedScene::environment() const {
  if (variations_ && !variations_->environment().empty()) return variations_->environment();
  const bool isSeen = job_.settings.background.kind == render::Background::Environment;
  return render::environmentName(scene_, job_.hdri, isSeen);
}

}  // namespace latelight::data
