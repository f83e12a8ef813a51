// The variation "environments": a random environment of a list, and a random rotation.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "data/variations/draws.h"
#include "data/variations/variation.h"

namespace latelight::data {

namespace {

// Names of environments that are not files.
bool isBuiltIn(const std::string& name) {
  return name == "studio" || name == "none";
}

class Environments : public Variation {
 public:
  explicit Environments(Spec& spec) : path_(spec.path()) {
    if (!spec.has("environments") && !spec.has("rotation"))
      badUsage("{} needs one of \"environments\" and \"rotation\"", path_);
    if (spec.has("environments")) environments_ = spec.texts("environments");
    if (spec.has("rotation")) rotation_ = spec.interval("rotation");
    std::error_code ignored;
    for (const std::string& name : environments_)
      if (!isBuiltIn(name) && !std::filesystem::exists(name, ignored))
        badInput("{}: there is no environment {}", spec.pathOf("environments"), name);
  }

  nlohmann::ordered_json draw(const Draw& draw, Draft& draft) const override {
    nlohmann::ordered_json record = nlohmann::ordered_json::object();
    if (!environments_.empty()) {
      const auto count = static_cast<uint32_t>(environments_.size());
      record["environment"] = draft.environment = environments_[draw.of(path_ + "/environment").below(count)];
    }
    if (rotation_) {
      draft.environmentRotation = drawn(*rotation_, draw.of(path_ + "/rotation"));
      record["rotation"] = *draft.environmentRotation;
    }
    return record;
  }

  std::vector<std::string> possibleEnvironments() const override { return environments_; }

 private:
  std::string path_;
  std::vector<std::string> environments_;
  std::optional<Interval> rotation_;
};

}  // namespace

std::vector<std::filesystem::path> environmentsFiles(const nlohmann::ordered_json& value,
                                                     const scene::LoadOptions& /*load*/) {
  std::vector<std::filesystem::path> files;
  for (const nlohmann::ordered_json& name : value.value("environments", nlohmann::ordered_json()))
    if (name.is_string() && !isBuiltIn(name.get<std::string>())) files.emplace_back(name.get<std::string>());
  return files;
}

std::unique_ptr<Variation> varyEnvironments(Spec& spec, const VariationContext& /*context*/) {
  return std::make_unique<Environments>(spec);
}

}  // namespace latelight::data
