// The variation "lights": random changes of the scene's lights, in intensity, color temperature, position and number.
#include <fmt/format.h>

#include <optional>

#include "base/error.h"
#include "data/variations/draws.h"
#include "data/variations/pattern.h"
#include "data/variations/temperature.h"
#include "data/variations/variation.h"
#include "scene/file_frame.h"

namespace latelight::data {

namespace {

using Json = nlohmann::ordered_json;

class Lights : public Variation {
 public:
  Lights(Spec& spec, const scene::Scene& scene) : path_(spec.path()) {
    lights_ = selectLights(spec, "lights", scene);
    if (spec.has("intensity")) intensity_ = spec.interval("intensity", kNotNegative);
    if (spec.has("temperature")) temperature_ = spec.interval("temperature", {kMinTemperature, kMaxTemperature});
    if (spec.has("jitter")) jitter_ = spec.number("jitter", kNotNegative);
    if (spec.has("on")) on_ = spec.counts("on", lights_.size());
    if (!intensity_ && !temperature_ && !jitter_ && !on_)
      badUsage("{} needs one of \"intensity\", \"temperature\", \"jitter\" and \"on\"", path_);
  }

  Json draw(const Draw& draw, Draft& draft) const override {
    std::vector<bool> on(lights_.size(), !on_);
    if (on_) {
      const uint32_t count = drawn(*on_, draw.of(path_ + "/count"));
      for (const uint32_t lit : draw.of(path_ + "/on").choose(count, static_cast<uint32_t>(lights_.size())))
        on[lit] = true;
    }
    Json record{{"lights", Json::array()}};
    for (size_t i = 0; i < lights_.size(); ++i)
      record["lights"].push_back(change(draw, lights_[i], on[i], fileFromWorld(draft.scene), draft.light(lights_[i])));
    return record;
  }

 private:
  Json change(const Draw& draw, uint32_t index, bool on, const glm::dmat4& fromWorld, scene::Light& light) const {
    const auto random = [&](const char* what) { return draw.of(fmt::format("{}/{}/{}", path_, index, what)); };
    Json record{{"name", light.name}};
    if (intensity_) light.intensity *= drawn(*intensity_, random("intensity"));
    if (temperature_) {
      const float kelvin = drawn(*temperature_, random("temperature"));
      light.color = colorOfTemperature(kelvin);
      record["temperature"] = kelvin;
    }
    if (jitter_) {
      const glm::dvec3 reach(*jitter_);
      const glm::dvec3 moved = drawn(Spec::Corners{-reach, reach}, random("jitter"));
      light.position += moved;
      light.node = -1;  // the light no longer follows its node
      record["position"] = listOf(glm::dvec3(fromWorld * glm::dvec4(light.position, 1)));
    }
    if (!on) light.intensity = 0;
    record["intensity"] = light.intensity;
    return record;
  }

  std::string path_;
  std::vector<uint32_t> lights_;
  std::optional<Interval> intensity_, temperature_;
  std::optional<double> jitter_;
  std::optional<Spec::Counts> on_;
};

}  // namespace

std::unique_ptr<Variation> varyLights(Spec& spec, const VariationContext& context) {
  return std::make_unique<Lights>(spec, context.scene);
}

}  // namespace latelight::data
