#include "data/variations/variations.h"

#include "base/error.h"

namespace latelight::data {

struct Variations::Impl {
  std::string environment;
};

Variations::Variations(const nlohmann::ordered_json& spec, scene::Scene& scene, uint64_t seed)
    : impl_(std::make_unique<Impl>()) {
  if (!spec.is_null()) badUsage("variations: not known yet");
}
Variations::~Variations() = default;

nlohmann::ordered_json Variations::apply(uint64_t number) {
  return nullptr;
}
const std::string& Variations::environment() const {
  return impl_->environment;
}

}  // namespace latelight::data
