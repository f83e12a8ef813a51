#include "data/amodal.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "render/view.h"
#include "scene/framing.h"

namespace latelight::data {

namespace {

constexpr uint64_t kPixelsAtOnce = uint64_t{1} << 25;  // of all views of a submission: 128 MiB of ids
constexpr uint32_t kWidest = 16384;                    // as --size has it

using Taken = std::function<void(Object&, const output::AovImage&)>;

// Some objects, alone, from copies of one camera.
class Views {
 public:
  Views(render::Renderer& renderer, const render::Settings& settings, const render::Moment& moment)
      : renderer_(renderer), settings_(settings), poses_{moment.poses, {}, {}, false} {
    settings_.display = false;
    settings_.aovs = {output::Aov::Id};
  }

  // While some are looked at, the next are rendered.
  void render(const scene::Camera& camera, const std::vector<Object*>& objects, const Taken& taken) {
    const uint64_t most = std::max<uint64_t>(1, kPixelsAtOnce / (uint64_t{settings_.width} * settings_.height));
    std::optional<render::Ticket> before;
    for (size_t first = 0; first < objects.size() + most; first += most) {
      std::optional<render::Ticket> now;
      std::vector<scene::Camera> cameras;
      for (size_t i = first; i < std::min<size_t>(first + most, objects.size()); ++i) {
        cameras.push_back(camera);
        cameras.back().object = objects[i]->id;
      }
      if (!cameras.empty()) now.emplace(renderer_.submit(cameras, settings_, poses_));
      if (before) {
        const std::vector<output::FrameOutput> pictures = before->take();
        for (size_t i = 0; i < pictures.size(); ++i) taken(*objects[first - most + i], pictures[i].aovs.front());
      }
      before = std::move(now);
    }
  }

 private:
  render::Renderer& renderer_;
  render::Settings settings_;
  render::Moment poses_;
};

// How a box lies to a picture, by its corners.
enum class Lies { Outside, Across, Inside };
Lies liesIn(const shared::View& view, const glm::dmat4& viewFromObject, const Object& object) {
  const shared::Projection& p = view.projection;
  const bool perspective = p.kind == shared::kPerspective;
  int beyond[4] = {0, 0, 0, 0};  // corners, of each side
  bool inside = true;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec4 at((corner & 1) != 0 ? object.high.x : object.low.x,
                        (corner & 2) != 0 ? object.high.y : object.low.y,
                        (corner & 4) != 0 ? object.high.z : object.low.z, 1);
    const glm::dvec3 c(viewFromObject * at);
    const double w = perspective ? c.y : 1;
    const double x = p.H * c.x + p.X * w, z = p.V * c.z + p.Z * w;
    const double slack = 1e-4 * (std::abs(c.x) + std::abs(c.y) + std::abs(c.z));  // for rounding
    inside = inside && (!perspective || w > slack) && std::abs(x) < w - slack && std::abs(z) < w - slack;
    for (int side = 0; side < 4; ++side) {
      const double out = side < 2 ? (side == 0 ? x : -x) : (side == 2 ? z : -z);
      beyond[side] += out > w + slack;
    }
  }
  if (std::ranges::find(beyond, 8) != std::end(beyond)) return Lies::Outside;
  return inside ? Lies::Inside : Lies::Across;
}

// The same camera's view of a picture three times as wide and high, around its own; nothing where there is none.
std::optional<scene::Camera> widened(const scene::Camera& camera, const render::Settings& settings) {
  if (camera.lens || 3 * std::max(settings.width, settings.height) > kWidest) return std::nullopt;
  scene::Camera wide = camera;
  wide.verticalFov = 2 * std::atan(3 * std::tan(camera.verticalFov / 2));
  wide.yHalf = 3 * camera.yHalf;
  wide.principal = camera.principal / 3.0f;
  if (!wide.orthographic && !scene::showsSomething(wide.verticalFov)) return std::nullopt;
  return wide;
}

PixelBox around(const PixelBox& a, const PixelBox& b) {
  if (a.width == 0) return b;
  const int64_t x = std::min(a.x, b.x), y = std::min(a.y, b.y);
  return {x, y, std::max(a.x + a.width, b.x + b.width) - x, std::max(a.y + a.height, b.y + b.height) - y};
}

// Adds what a picture three times as large shows of the object outside of its middle.
void addBeyond(Object& object, const output::AovImage& wide) {
  const uint32_t width = wide.width / 3, height = wide.height / 3;
  for (uint32_t y = 0; y < wide.height; ++y)
    for (uint32_t x = 0; x < wide.width; ++x) {
      const bool middle = x >= width && x < 2 * width && y >= height && y < 2 * height;
      if (middle || wide.ids[size_t{y} * wide.width + x] != object.id) continue;
      ++object.pixels;
      object.full = around(object.full, {int64_t{x} - width, int64_t{y} - height, 1, 1});
    }
}

}  // namespace

void renderAlone(render::Renderer& renderer, const scene::Scene& scene, const scene::Camera& camera,
                 const render::Settings& settings, const render::Moment& moment, std::vector<Object>& objects) {
  const bool zUp = !scene.yUp || settings.axes == render::Axes::ZUp;
  const shared::View view = render::makeView(camera, settings.width, settings.height);
  std::vector<Object*> seen, across;
  for (Object& object : objects) {
    object.alone = {settings.width, settings.height, {settings.width * settings.height}};
    const glm::dmat4 viewFromObject =
        glm::dmat4(glm::mat4(view.worldToView) * (zUp ? glm::mat4(1) : scene::toWorldFromGltf())) * object.toWorld;
    const Lies lies = camera.lens ? Lies::Inside : liesIn(view, viewFromObject, object);
    if (lies != Lies::Outside) seen.push_back(&object);
    if (lies == Lies::Across) across.push_back(&object);
  }
  Views(renderer, settings, moment).render(camera, seen, [](Object& object, const output::AovImage& ids) {
    const std::map<uint32_t, Mask> masks = masksOf(ids);
    if (masks.empty()) return;
    object.alone = masks.at(object.id);
    object.pixels = object.alone.area();
    object.full = object.alone.box();
  });
  const std::optional<scene::Camera> wide = widened(camera, settings);
  if (!wide) return;
  render::Settings large = settings;
  large.width *= 3;
  large.height *= 3;
  Views(renderer, large, moment).render(*wide, across, addBeyond);
}

}  // namespace latelight::data
