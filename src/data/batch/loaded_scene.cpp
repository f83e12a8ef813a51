#include "data/batch/loaded_scene.h"

#include <algorithm>

#include "base/error.h"
#include "render/submit/session.h"

namespace latelight::data {

LoadedScene::LoadedScene(const Job& job, scene::Scene scene) try
    : job_(job), scene_(std::move(scene)), cameras_(job, scene_) {
  if (job.variations.is_null()) return;
  variations_.emplace(job.variations, scene_, job.seed, job.load);
  if (std::ranges::any_of(job.settings.aovs, output::holdsIds))
    idsOfAll_ = std::make_shared<output::IdManifest>(variations_->idsOfAll());
} catch (const Error& error) {
  throw Error(error.code(), job.places.located(error.what()));
}

const nlohmann::ordered_json& LoadedScene::show(uint32_t variation) {
  if (variations_ && shown_ != variation) {
    drawn_ = variations_->apply(variation);
    cameras_.follow(variations_->movedNodes());
  }
  shown_ = variation;
  return drawn_;
}

std::optional<double> LoadedScene::environmentRotation() const {
  return variations_ ? variations_->environmentRotation() : std::nullopt;
}

std::map<uint32_t, scene::dmat4> LoadedScene::movedNodes() const {
  return variations_ ? variations_->movedNodes() : std::map<uint32_t, scene::dmat4>();
}

std::string LoadedScene::environment() const {
  const bool isDrawn = variations_ && !variations_->environment().empty();
  return environmentFor(isDrawn ? variations_->environment() : job_.hdri);
}

bool LoadedScene::hasEnvironmentInAllVariations() const {
  std::vector<std::string> requested;
  if (variations_) requested = variations_->possibleEnvironments();
  if (requested.empty()) requested = {job_.hdri};
  return std::ranges::none_of(requested, [&](const std::string& name) { return environmentFor(name).empty(); });
}

// `requested`: a name as for --hdri; empty: the scene chooses.
std::string LoadedScene::environmentFor(const std::string& requested) const {
  const bool isSeen = job_.settings.background.kind == render::Background::Environment;
  return render::environmentName(scene_, requested, isSeen);
}

}  // namespace latelight::data
