#include <filesystem>

#include "base/error.h"
#include "data/variations/variation.h"

namespace latelight::data {

namespace {

class Environments : public Variation {
 public:
  explicit Environments(Spec& spec) : path_(spec.path()), environments_(spec.texts("environments")) {
    std::error_code ignored;
    for (const std::string& name : environments_)
      if (name != "studio" && name != "none" && !std::filesystem::exists(name, ignored))
        badInput("{}: there is no environment {}", spec.pathOf("environments"), name);
  }

  nlohmann::ordered_json draw(const Draw& draw, Draft& draft) const override {
    draft.environment = environments_[draw.of(path_).below(static_cast<uint32_t>(environments_.size()))];
    return {{"environment", draft.environment}};
  }

 private:
  std::string path_;
  std::vector<std::string> environments_;
};

}  // namespace

std::unique_ptr<Variation> varyEnvironments(Spec& spec, scene::Scene&) {
  return std::make_unique<Environments>(spec);
}

}  // namespace latelight::data
