#include "motion/reference_motion.h"

#include <algorithm>
#include <cmath>

#include "render/frame/view.h"

namespace latelight::render::test {

namespace {

using glm::dvec2;
using glm::dvec3;

struct DoubleView {
  DoubleView(const scene::Camera& camera, uint32_t width, uint32_t height)
      : view(makeView(camera, width, height)), worldToView(glm::dmat4x3(view.worldToView)) {}
  dvec3 toView(dvec3 world) const { return worldToView * glm::dvec4(world, 1); }
  dvec2 pixel(dvec3 v) const {
    const shared::Projection& p = view.projection;
    const double w = p.kind == shared::kPerspective ? v.y : 1;
    const dvec2 ndc((p.H * v.x) / w + p.X, (p.V * v.z) / w + p.Z);
    return {(ndc.x + 1) * 0.5 * view.size.x, (1 - ndc.y) * 0.5 * view.size.y};
  }
  dvec3 ray(dvec2 pixel) const {
    const shared::Projection& p = view.projection;
    return {(2 * pixel.x / view.size.x - 1 - p.X) / p.H, 1, (1 - 2 * pixel.y / view.size.y - p.Z) / p.V};
  }
  shared::View view;
  glm::dmat4x3 worldToView;
};

class Caster {
 public:
  Caster(const SceneState& moment, const scene::Camera& camera, uint32_t width, uint32_t height)
      : width_(width),
        height_(height),
        now_(camera, width, height),
        before_(moment.previousCameras.empty() ? camera : moment.previousCameras.front(), width, height),
        after_(moment.nextCameras.empty() ? camera : moment.nextCameras.front(), width, height),
        pixels_(size_t{width} * height) {}

  struct Corner {
    dvec3 now, before, after;  // in world space
  };
  void add(const Corner (&corners)[3]) {
    dvec3 v[3];
    for (int i = 0; i < 3; ++i) v[i] = now_.toView(corners[i].now);
    const Area area = areaOf(v);
    for (int y = area.top; y <= area.bottom; ++y)
      for (int x = area.left; x <= area.right; ++x) cast(corners, v, x, y);
  }
  std::vector<ReferencePixel> take() { return std::move(pixels_); }

 private:
  struct Area {
    int left, right, top, bottom;
  };
  Area areaOf(const dvec3 (&v)[3]) const {
    const Area all{0, int(width_) - 1, 0, int(height_) - 1};
    dvec2 low(1e30), high(-1e30);
    for (const dvec3& corner : v) {
      if (corner.y < 1e-3) return all;  // crosses the plane of the eye
      low = glm::min(low, now_.pixel(corner));
      high = glm::max(high, now_.pixel(corner));
    }
    const auto within = [](double x, int most) { return int(std::clamp(std::floor(x), -1.0, double(most))); };
    return {std::max(within(low.x - 1, all.right + 1), 0), within(high.x + 1, all.right),
            std::max(within(low.y - 1, all.bottom + 1), 0), within(high.y + 1, all.bottom)};
  }

  // The ray starts at the eye, so barycentric coordinates are triple products with it.
  void cast(const Corner (&corners)[3], const dvec3 (&v)[3], int x, int y) {
    const dvec3 ray = now_.ray({x + 0.5, y + 0.5});
    dvec3 weight(glm::dot(ray, glm::cross(v[1], v[2])), glm::dot(ray, glm::cross(v[2], v[0])),
                 glm::dot(ray, glm::cross(v[0], v[1])));
    const double sum = weight.x + weight.y + weight.z;
    if (sum == 0) return;
    weight /= sum;
    if (weight.x < 0 || weight.y < 0 || weight.z < 0) return;
    const double depth = weight.x * v[0].y + weight.y * v[1].y + weight.z * v[2].y;
    ReferencePixel& pixel = pixels_[size_t(y) * width_ + size_t(x)];
    if (depth <= 0 || (pixel.depth > 0 && depth >= pixel.depth)) return;
    const auto at = [&](dvec3 Corner::*when) {
      return corners[0].*when * weight.x + corners[1].*when * weight.y + corners[2].*when * weight.z;
    };
    const dvec2 here(x + 0.5, y + 0.5);
    pixel.depth = depth;
    pixel.backward = before_.pixel(before_.toView(at(&Corner::before))) - here;
    pixel.forward = after_.pixel(after_.toView(at(&Corner::after))) - here;
  }

  uint32_t width_, height_;
  DoubleView now_, before_, after_;
  std::vector<ReferencePixel> pixels_;
};

}  // namespace

std::vector<dvec3> worldVertices(const scene::Scene& scene, size_t index, const scene::Pose& pose) {
  const scene::Instance& instance = scene.instances[index];
  const scene::Mesh& mesh = scene.meshes[instance.mesh];
  const glm::dmat4 toWorld(scene::instanceTransforms(scene, pose)[index]);
  std::vector<glm::vec3> positions = mesh.positions;
  if (mesh.deformation && !pose.empty()) {
    const scene::Deformation& d = *mesh.deformation;
    std::vector<glm::mat4> joints;
    if (d.skin >= 0) joints = scene::jointMatrices(scene.rig.skins[size_t(d.skin)], pose);
    std::vector<float> weights;
    if (d.weightsNode >= 0) weights = pose.weights[size_t(d.weightsNode)];
    positions = scene::deform(d, joints, weights).positions;
  }
  std::vector<dvec3> world;
  for (const glm::vec3& p : positions) world.emplace_back(toWorld * glm::dvec4(p, 1));
  return world;
}

dvec2 pixelOf(const scene::Camera& camera, uint32_t width, uint32_t height, dvec3 world) {
  const DoubleView view(camera, width, height);
  return view.pixel(view.toView(world));
}

std::vector<ReferencePixel> referenceMotion(const scene::Scene& scene, const SceneState& moment,
                                            const scene::Camera& camera, uint32_t width, uint32_t height) {
  Caster caster(moment, camera, width, height);
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const std::vector<dvec3> now = worldVertices(scene, i, moment.poses.current);
    const bool still = moment.poses.current.empty();
    const std::vector<dvec3> before = still ? now : worldVertices(scene, i, moment.poses.previous);
    const std::vector<dvec3> after = still ? now : worldVertices(scene, i, moment.poses.next);
    const std::vector<uint32_t>& indices = scene.meshes[scene.instances[i].mesh].indices;
    for (size_t t = 0; t + 2 < indices.size(); t += 3) {
      Caster::Corner corners[3];
      for (size_t c = 0; c < 3; ++c) {
        const uint32_t v = indices[t + c];
        corners[c] = {now[v], before[v], after[v]};
      }
      caster.add(corners);
    }
  }
  return caster.take();
}

}  // namespace latelight::render::test
