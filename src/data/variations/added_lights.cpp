// The variation "addedLights": adds lights of one type with random intensity, color temperature, position and
// direction.
#include <fmt/format.h>

#include <optional>

#include "base/error.h"
#include "data/variations/draws.h"
#include "data/variations/temperature.h"
#include "data/variations/variation.h"
#include "scene/exact_math.h"
#include "scene/file_frame.h"
#include "scene/light_types.h"
#include "shared/light.h"

namespace latelight::data {

namespace {

using Json = nlohmann::ordered_json;

constexpr uint64_t kMaxLights = 1'000'000;

bool hasDirection(uint32_t type) {
  return shared::lightIsDirectional(type) || shared::lightHasCone(type);
}

class AddedLights : public Variation {
 public:
  AddedLights(Spec& spec, const scene::Scene& scene) : path_(spec.path()) {
    count_ = spec.counts("count", kMaxLights);
    light_.type = readType(spec);
    intensity_ = spec.interval("intensity", kNotNegative);
    if (spec.has("temperature")) temperature_ = spec.interval("temperature", {kMinTemperature, kMaxTemperature});
    const bool local = !shared::lightIsDirectional(light_.type);
    if (local) place_ = {spec.vector("min"), spec.vector("max")};
    for (int axis = 0; axis < 3; ++axis)
      if (place_.low[axis] > place_.high[axis])
        badUsage("{} must be at most {} along each axis", spec.pathOf("min"), spec.pathOf("max"));
    if (local && spec.has("range")) light_.range = static_cast<float>(spec.number("range", kPositive));
    if (spec.has("castShadow")) light_.castShadow = spec.flag("castShadow", false);
    // Directions are within a cone around down; its half angle is `tilt_`, so 90 degrees is the lower hemisphere.
    if (hasDirection(light_.type)) tilt_ = spec.number("tilt", {0, 180}, 60.0);
    light_.direction = glm::vec3(0, 0, -1);
  }

  Json draw(const Draw& draw, Draft& draft) const override {
    Json record{{"lights", Json::array()}};
    const uint32_t count = drawn(count_, draw.of(path_ + "/count"));
    for (uint32_t i = 0; i < count; ++i) record["lights"].push_back(add(draw, i, draft));
    return record;
  }

 private:
  static uint32_t readType(Spec& spec) {
    const std::string name = spec.text("light", "point");
    const std::optional<uint32_t> type = scene::findLightType(name);
    if (!type) badUsage("{} must be a type listed by `latelight list lights`, not \"{}\"", spec.pathOf("light"), name);
    if (shared::lightIsArea(*type))
      badUsage("{} must be point, spot or directional, not {}: area lights cannot be added", spec.pathOf("light"),
               name);
    return *type;
  }

  Json add(const Draw& draw, uint32_t number, Draft& draft) const {
    const auto random = [&](const char* what) { return draw.of(fmt::format("{}/{}/{}", path_, number, what)); };
    const glm::dmat4 toWorld = worldFromFile(draft.scene);
    scene::Light light = light_;
    Json record = Json::object();
    light.intensity = drawn(intensity_, random("intensity"));
    record["intensity"] = light.intensity;
    if (temperature_) {
      const float kelvin = drawn(*temperature_, random("temperature"));
      light.color = colorOfTemperature(kelvin);
      record["temperature"] = kelvin;
    }
    if (!shared::lightIsDirectional(light.type)) {
      const glm::dvec3 position = drawn(place_, random("position"));
      light.position = glm::dvec3(toWorld * glm::dvec4(position, 1));
      record["position"] = listOf(position);
    }
    if (hasDirection(light.type)) {
      light.direction = downwards(random("direction"));
      record["direction"] = listOf(glm::transpose(glm::mat3(toWorld)) * light.direction);
    }
    draft.addedLights.push_back(light);
    return record;
  }

  // Returns a random direction in the world, where up is Z. Directions are uniform by solid angle within the cone.
  glm::vec3 downwards(Random random) const {
    const double z = -random.between(exact::cosQuarters(tilt_ / 90), 1);
    const glm::dvec2 flat = exact::onCircle(random.unit()) * std::sqrt(1 - z * z);
    return glm::normalize(glm::dvec3(flat, z));
  }

  std::string path_;
  Spec::Counts count_;
  Interval intensity_;
  std::optional<Interval> temperature_;
  Spec::Corners place_;
  double tilt_ = 0;  // in degrees
  scene::Light light_;
};

}  // namespace

std::unique_ptr<Variation> addLights(Spec& spec, const VariationContext& context) {
  return std::make_unique<AddedLights>(spec, context.scene);
}

}  // namespace latelight::data
