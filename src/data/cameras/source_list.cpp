// The camera source "list": cameras whose poses and intrinsics the job lists one by one.
#include "data/cameras/optics.h"
#include "data/cameras/pose_spec.h"
#include "data/cameras/source.h"

namespace latelight::data {

std::vector<Shot> shotsOfList(Spec& spec, const CameraContext& context) {
  const Optics normal = readOptics(spec, context.size);
  std::vector<Spec> entries = spec.objects("cameras");
  uint64_t names = 0;
  for (Spec& entry : entries) names += entry.has("name") ? entry.text("name").size() : kNumberedNameBytes;
  context.claim(spec, entries.size(), names);
  std::vector<Shot> shots;
  for (Spec& entry : entries) {
    const Optics optics = hasOptics(entry) ? readOptics(entry, context.size) : normal;
    const std::string name = entry.text("name", numberedName("camera", shots.size(), entries.size()));
    shots.push_back({name, readPose(entry, context), optics.camera, optics.width, optics.height});
    shots.back().exposure = readExposure(entry);
    entry.finish();
  }
  return shots;
}

}  // namespace latelight::data
