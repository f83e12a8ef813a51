#include "labels/amodal.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <tuple>
#include <unordered_map>

#include "render/frame/view.h"
#include "render/submit/session.h"
#include "scene/framing.h"

namespace latelight::labels {

namespace {

constexpr uint64_t kPixelsAtOnce = uint64_t{1} << 25;  // in all views of a submission: 128 MiB of ids
constexpr uint64_t kMaxViews = 4096;                   // per submission
constexpr uint32_t kWidest = 16384;                    // the limit of --size

// The position of an object's box relative to a picture, derived from the box's projected corners.
struct ScreenBounds {
  enum Containment { Outside, Across, Inside } containment;
  double left, right, top, bottom;  // screen bounds: conservative, in pixels, y down
};

ScreenBounds screenBoundsOf(const shared::View& view, const glm::dmat4& viewFromObject, const Object& object) {
  const shared::Projection& p = view.projection;
  const bool perspective = p.kind == shared::kPerspective;
  ScreenBounds bounds{ScreenBounds::Inside, view.size.x, 0, view.size.y, 0};
  int beyond[4] = {0, 0, 0, 0};  // number of corners beyond each side of the frustum
  for (const glm::dvec3 corner : cornersOf(object)) {
    const glm::dvec3 c(viewFromObject * glm::dvec4(corner, 1));
    const double w = perspective ? c.y : 1, slack = 1e-4 * (std::abs(c.x) + std::abs(c.y) + std::abs(c.z));
    const double x = p.H * c.x + p.X * w, z = p.V * c.z + p.Z * w;
    if ((perspective && w <= slack) || std::abs(x) >= w - slack || std::abs(z) >= w - slack)
      bounds.containment = ScreenBounds::Across;
    const double outside[4] = {x, -x, z, -z};
    for (int side = 0; side < 4; ++side) beyond[side] += outside[side] > w + slack;
    const bool seen = !perspective || w > slack;
    const double column = (x / w + 1) / 2 * view.size.x, row = (1 - z / w) / 2 * view.size.y;
    bounds.left = std::min(bounds.left, seen ? column - 2 : 0);
    bounds.right = std::max(bounds.right, seen ? column + 2 : view.size.x);
    bounds.top = std::min(bounds.top, seen ? row - 2 : 0);
    bounds.bottom = std::max(bounds.bottom, seen ? row + 2 : view.size.y);
  }
  if (std::ranges::find(beyond, 8) != std::end(beyond)) bounds.containment = ScreenBounds::Outside;
  return bounds;
}

bool overlap(const ScreenBounds& a, const ScreenBounds& b) {
  return a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
}

struct BoundedObject {
  Object* object;
  ScreenBounds bounds;
};
using Group = std::vector<BoundedObject>;

// Distributes objects to groups in which no screen bounds overlap (greedy, first fit).
std::vector<Group> apart(const std::vector<BoundedObject>& objects) {
  std::vector<Group> groups;
  for (const BoundedObject& each : objects) {
    const auto meets = [&](const BoundedObject& other) { return overlap(each.bounds, other.bounds); };
    const auto free =
        std::ranges::find_if(groups, [&](const Group& group) { return std::ranges::none_of(group, meets); });
    (free == groups.end() ? groups.emplace_back() : *free).push_back(each);
  }
  return groups;
}

// Renders objects in isolation with one camera: each group of objects has a view of its own.
class IsolatedRenderer {
 public:
  IsolatedRenderer(render::Renderer& renderer, const scene::Scene& scene, const scene::Camera& camera,
                   const render::Settings& settings, const render::SceneState& moment, bool order)
      : renderer_(renderer),
        scene_(scene),
        camera_(camera),
        settings_(settings),
        moment_(render::onlyReadout(moment, settings)) {
    settings_.display = false;
    settings_.aovs = {output::Aov::Id};
    if (order) settings_.aovs.push_back(output::Aov::Distance);
    const bool zUp = !scene.yUp || settings.axes == render::Axes::ZUp;
    view_ = render::makeView(camera, settings.width, settings.height);
    viewFromPositions_ = glm::inverse(render::rigidPose(camera)) * (zUp ? glm::dmat4(1) : scene::toWorldFromGltf());
  }

  BoundedObject bounded(Object& object) const {
    // Rows that are read out at different times show an object anywhere near its bounds.
    if (camera_.lens || settings_.readout != 0)
      return {&object, {ScreenBounds::Inside, 0, view_.size.x, 0, view_.size.y}};
    return {&object, screenBoundsOf(view_, viewFromPositions_ * object.toWorld, object)};
  }

  // Calls taken() with each picture and the objects in it. The next pictures are rendered while taken() reads these.
  using Taken = std::function<void(const Group&, const std::vector<output::AovImage>&)>;
  void render(const std::vector<BoundedObject>& objects, const Taken& taken) {
    const std::vector<Group> groups = apart(objects);
    const uint64_t pixels = uint64_t{settings_.width} * settings_.height;
    const size_t most = std::clamp<uint64_t>(kPixelsAtOnce / pixels, 1, kMaxViews);
    std::optional<render::Ticket> before;
    for (size_t first = 0; first < groups.size() + most; first += most) {
      const size_t end = std::min(first + most, groups.size());
      std::optional<render::Ticket> now;
      if (first < end) now.emplace(submit(std::span(groups).subspan(first, end - first)));
      if (before) {
        const std::vector<output::FrameOutput> pictures = before->take().frames;
        for (size_t i = 0; i < pictures.size(); ++i) taken(groups[first - most + i], pictures[i].aovs);
      }
      before = std::move(now);
    }
  }

 private:
  render::Ticket submit(std::span<const Group> groups) {
    std::unordered_map<uint32_t, uint32_t> groupOf;  // group number, from 1, by id
    for (uint32_t i = 0; i < groups.size(); ++i)
      for (const BoundedObject& each : groups[i]) groupOf[each.object->id] = i + 1;
    moment_.groups.assign(scene_.instances.size(), 0);
    for (size_t i = 0; i < scene_.instances.size(); ++i)
      if (const auto group = groupOf.find(scene_.instances[i].id); group != groupOf.end())
        moment_.groups[i] = group->second;
    std::vector<scene::Camera> cameras(groups.size(), camera_);
    for (uint32_t i = 0; i < cameras.size(); ++i) cameras[i].group = i + 1;
    render::SceneState state = moment_;
    for (auto* neighbors : {&state.previousCameras, &state.nextCameras})
      if (!neighbors->empty()) neighbors->assign(cameras.size(), neighbors->front());
    for (auto* seconds : {&state.motion.sincePrevious, &state.motion.untilNext})
      if (!seconds->empty()) seconds->assign(cameras.size(), seconds->front());
    return renderer_.submit(cameras, settings_, state);
  }

  render::Renderer& renderer_;
  const scene::Scene& scene_;
  scene::Camera camera_;
  render::Settings settings_;
  render::SceneState moment_;
  shared::View view_;
  glm::dmat4 viewFromPositions_;
};

void takeMasks(const Group& group, const output::AovImage& ids) {
  std::map<uint32_t, Mask> masks = masksOf(ids);
  for (const BoundedObject& each : group) {
    const auto mask = masks.find(each.object->id);
    if (mask == masks.end()) continue;
    each.object->pixels = mask->second.area();
    each.object->full = mask->second.box();
    each.object->alone = std::move(mask->second);
  }
}

// Counts the pixels at which objects are in front of each other, from the distances of isolated objects.
class DepthOrder {
 public:
  void add(const Group& group, const output::AovImage& ids, const output::AovImage& distances) {
    std::unordered_map<uint32_t, Object*> objects;
    for (const BoundedObject& each : group) objects[each.object->id] = each.object;
    for (uint32_t i = 0; i < ids.ids.size(); ++i)
      if (ids.ids[i] != 0) covered_.push_back({i, distances.values[i], objects.at(ids.ids[i])});
  }

  void finish() {
    std::ranges::sort(covered_, {}, [](const Covered& c) { return std::tuple(c.pixel, c.distance, c.object->id); });
    std::map<std::pair<Object*, uint32_t>, uint64_t> pixels;
    for (size_t i = 0; i < covered_.size(); ++i)
      for (size_t j = i + 1; j < covered_.size() && covered_[j].pixel == covered_[i].pixel; ++j)
        if (covered_[i].distance < covered_[j].distance) ++pixels[{covered_[i].object, covered_[j].object->id}];
    for (const auto& [pair, count] : pixels) pair.first->occludes.push_back({pair.second, count});
  }

 private:
  struct Covered {
    uint32_t pixel;
    float distance;
    Object* object;
  };
  std::vector<Covered> covered_;
};

// Returns the camera for a picture three times as wide and high around the camera's own picture. Empty for cameras with
// a lens, and if the picture would be too large or the field of view too wide.
std::optional<scene::Camera> widened(const scene::Camera& camera, const render::Settings& settings) {
  if (camera.lens || 3 * std::max(settings.width, settings.height) > kWidest) return std::nullopt;
  scene::Camera wide = camera;
  wide.verticalFov = 2 * std::atan(3 * std::tan(camera.verticalFov / 2));
  wide.yHalf = 3 * camera.yHalf;
  wide.principal = camera.principal / 3.0f;
  if (!wide.orthographic && !scene::isUsableFieldOfView(wide.verticalFov)) return std::nullopt;
  return wide;
}

PixelBox around(const PixelBox& a, const PixelBox& b) {
  if (a.width == 0) return b;
  const int64_t x = std::min(a.x, b.x), y = std::min(a.y, b.y);
  return {x, y, std::max(a.x + a.width, b.x + b.width) - x, std::max(a.y + a.height, b.y + b.height) - y};
}

// Adds the pixels that objects cover in the enlarged picture outside its central third, which is the original picture.
void addBeyond(const Group& group, const std::vector<output::AovImage>& pictures) {
  const output::AovImage& wide = pictures.front();
  std::unordered_map<uint32_t, Object*> objects;
  for (const BoundedObject& each : group) objects[each.object->id] = each.object;
  const uint32_t width = wide.width / 3, height = wide.height / 3;
  for (uint32_t y = 0; y < wide.height; ++y)
    for (uint32_t x = 0; x < wide.width; ++x) {
      const uint32_t id = wide.ids[size_t{y} * wide.width + x];
      const bool middle = x >= width && x < 2 * width && y >= height && y < 2 * height;
      if (id == 0 || middle) continue;
      Object& object = *objects.at(id);
      ++object.pixels;
      object.full = around(object.full, {int64_t{x} - width, int64_t{y} - height, 1, 1});
    }
}

}  // namespace

void renderIsolated(render::Renderer& renderer, const scene::Scene& scene, const scene::Camera& camera,
                    const render::Settings& settings, const render::SceneState& moment, std::vector<Object>& objects,
                    bool order) {
  IsolatedRenderer alone(renderer, scene, camera, settings, moment, order);
  std::vector<BoundedObject> seen;
  std::vector<Object*> across;
  for (Object& object : objects) {
    object.alone = {settings.width, settings.height, {settings.width * settings.height}};
    const BoundedObject each = alone.bounded(object);
    if (each.bounds.containment != ScreenBounds::Outside) seen.push_back(each);
    if (each.bounds.containment == ScreenBounds::Across) across.push_back(&object);
  }
  DepthOrder depths;
  alone.render(seen, [&](const Group& group, const std::vector<output::AovImage>& pictures) {
    takeMasks(group, pictures.front());
    if (order) depths.add(group, pictures.front(), pictures.back());
  });
  depths.finish();
  const std::optional<scene::Camera> wide = widened(camera, settings);
  if (!wide) return;
  render::Settings large = settings;
  large.width *= 3;
  large.height *= 3;
  IsolatedRenderer beyond(renderer, scene, *wide, large, moment, false);
  std::vector<BoundedObject> bounded;
  for (Object* object : across) bounded.push_back(beyond.bounded(*object));
  beyond.render(bounded, addBeyond);
}

}  // namespace latelight::labels
