// The variation "visibility": hides nodes at random, by a probability per node or by the number of visible nodes.
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "base/error.h"
#include "data/variations/draws.h"
#include "data/variations/pattern.h"
#include "data/variations/variation.h"

namespace latelight::data {

namespace {

using Json = nlohmann::ordered_json;

class Visibility : public Variation {
 public:
  Visibility(Spec& spec, const scene::Scene& scene) : path_(spec.path()) {
    nodes_ = selectNodes(spec, "nodes", scene);
    if (spec.has("probability") == spec.has("visible"))
      badUsage("{} needs either \"probability\" or \"visible\"", path_);
    if (spec.has("probability")) probability_ = spec.number("probability", {0, 1});
    if (spec.has("visible")) visible_ = spec.counts("visible", nodes_.size());
  }

  Json draw(const Draw& draw, Draft& draft) const override {
    const std::set<uint32_t> seen = visible_ ? chosen(draw) : drawIndependently(draw);
    Json record{{"visible", Json::array()}};
    for (const uint32_t node : seen) record["visible"].push_back(draft.scene.nodes[node].path);
    for (const uint32_t node : nodes_)
      if (seen.contains(node))
        draft.hiddenNodes.erase(node);
      else
        draft.hiddenNodes.insert(node);
    return record;
  }

 private:
  std::set<uint32_t> chosen(const Draw& draw) const {
    const uint32_t count = drawn(*visible_, draw.of(path_ + "/count"));
    std::set<uint32_t> seen;
    for (const uint32_t i : draw.of(path_ + "/visible").choose(count, static_cast<uint32_t>(nodes_.size())))
      seen.insert(nodes_[i]);
    return seen;
  }
  std::set<uint32_t> drawIndependently(const Draw& draw) const {
    std::set<uint32_t> seen;
    for (const uint32_t node : nodes_)
      if (draw.of(fmt::format("{}/{}", path_, node)).unit() < probability_) seen.insert(node);
    return seen;
  }

  std::string path_;
  std::vector<uint32_t> nodes_;
  double probability_ = 0;
  std::optional<Spec::Counts> visible_;
};

}  // namespace

std::unique_ptr<Variation> varyVisibility(Spec& spec, const VariationContext& context) {
  return std::make_unique<Visibility>(spec, context.scene);
}

}  // namespace latelight::data
