// The variation "materials": random base color, roughness, metalness and emission of materials.
#include <fmt/format.h>

#include <optional>

#include "base/error.h"
#include "data/variations/draws.h"
#include "data/variations/pattern.h"
#include "data/variations/variation.h"

namespace latelight::data {

namespace {

using Json = nlohmann::ordered_json;

class Materials : public Variation {
 public:
  Materials(Spec& spec, const scene::Scene& scene) : path_(spec.path()) {
    materials_ = selectMaterials(spec, "materials", scene);
    constexpr Limits kShare{0, 1};
    if (spec.has("baseColor")) baseColor_ = spec.corners("baseColor", kShare);
    if (spec.has("roughness")) roughness_ = spec.interval("roughness", kShare);
    if (spec.has("metallic")) metallic_ = spec.interval("metallic", kShare);
    if (spec.has("emissive")) emissive_ = spec.corners("emissive", kNotNegative);
    if (!baseColor_ && !roughness_ && !metallic_ && !emissive_)
      badUsage("{} needs one of \"baseColor\", \"roughness\", \"metallic\" and \"emissive\"", path_);
  }

  Json draw(const Draw& draw, Draft& draft) const override {
    Json record{{"materials", Json::array()}};
    for (const uint32_t index : materials_) {
      shared::Material& data = draft.material(index).data;
      Json& own = record["materials"].emplace_back(Json{{"name", draft.scene.materials[index].name}});
      const auto random = [&](const char* what) { return draw.of(fmt::format("{}/{}/{}", path_, index, what)); };
      if (baseColor_) {
        data.baseColor = glm::vec4(drawn(*baseColor_, random("baseColor")), data.baseColor.a);
        own["baseColor"] = listOf(glm::vec3(data.baseColor));
      }
      if (roughness_) own["roughness"] = data.roughness = drawn(*roughness_, random("roughness"));
      if (metallic_) own["metallic"] = data.metallic = drawn(*metallic_, random("metallic"));
      if (emissive_) own["emissive"] = listOf(data.emissive = drawn(*emissive_, random("emissive")));
    }
    return record;
  }

 private:
  std::string path_;
  std::vector<uint32_t> materials_;
  std::optional<Spec::Corners> baseColor_, emissive_;
  std::optional<Interval> roughness_, metallic_;
};

}  // namespace

std::unique_ptr<Variation> varyMaterials(Spec& spec, const VariationContext& context) {
  return std::make_unique<Materials>(spec, context.scene);
}

}  // namespace latelight::data
