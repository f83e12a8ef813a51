#include "labels/amodal.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <tuple>
#include <unordered_map>

#include "render/exposure/camera_motion.h"
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

// An object of a view.
struct BoundedObject {
  Object* object;
  ScreenBounds bounds;
  bool requested;  // false: it has no image in this view, but is visible in the view's image of its group
};
// The objects with one id, in the views that have them, by index.
using ObjectInViews = std::map<size_t, BoundedObject>;
using Group = std::vector<const ObjectInViews*>;

bool overlap(const ObjectInViews& a, const ObjectInViews& b) {
  return std::ranges::any_of(a, [&](const auto& each) {
    const auto other = b.find(each.first);
    if (other == b.end() || !(each.second.requested || other->second.requested)) return false;
    return overlap(each.second.bounds, other->second.bounds);
  });
}

// Distributes objects to groups in which no screen bounds overlap in any view (greedy, first fit).
std::vector<Group> apart(const std::map<uint32_t, ObjectInViews>& objects) {
  std::vector<Group> groups;
  for (const auto& entry : objects) {
    const ObjectInViews& each = entry.second;
    const auto meets = [&](const ObjectInViews* other) { return overlap(each, *other); };
    const auto free =
        std::ranges::find_if(groups, [&](const Group& group) { return std::ranges::none_of(group, meets); });
    (free == groups.end() ? groups.emplace_back() : *free).push_back(&each);
  }
  return groups;
}

// A rendering of a group in a view.
struct IsolatedImage {
  uint32_t group, view;
  std::vector<Object*> objects;  // of the group, in the view
};

// Renders objects in isolation: each group of objects has an image of its own in each view.
class IsolatedRenderer {
 public:
  IsolatedRenderer(render::Renderer& renderer, const scene::Scene& scene, const std::vector<scene::Camera>& cameras,
                   const render::Settings& settings, const render::SceneState& moment, bool order)
      : renderer_(renderer),
        scene_(scene),
        cameras_(cameras),
        settings_(settings),
        moment_(render::onlyReadout(moment, settings)) {
    settings_.display = false;
    settings_.aovs = {output::Aov::Id};
    if (order) settings_.aovs.push_back(output::Aov::Distance);
    const bool zUp = !scene.yUp || settings.axes == render::Axes::ZUp;
    for (const scene::Camera& camera : cameras) {
      views_.push_back(render::makeView(camera, settings.width, settings.height));
      viewFromPositions_.push_back(glm::inverse(render::rigidPose(camera)) *
                                   (zUp ? glm::dmat4(1) : scene::toWorldFromGltf()));
    }
  }

  // Adds an object of a view unless the view does not show any of it. Returns the position of its bounds.
  ScreenBounds::Containment add(size_t view, Object& object) {
    const ScreenBounds bounds = boundsOf(view, object);
    if (bounds.containment != ScreenBounds::Outside)
      objects_[object.id].emplace(view, BoundedObject{&object, bounds, true});
    return bounds.containment;
  }

  // Keeps objects that share an image with this one from being occluded by it in a view to which it was not added. An
  // object has the same group in all views. Call it after add() has added the objects of all views.
  void avoid(size_t view, Object& object) {
    const auto views = objects_.find(object.id);
    if (views == objects_.end()) return;
    const ScreenBounds bounds = boundsOf(view, object);
    if (bounds.containment != ScreenBounds::Outside) views->second.emplace(view, BoundedObject{&object, bounds, false});
  }

  // Calls taken() with each image. The next images are rendered while taken() reads these.
  using Taken = std::function<void(const IsolatedImage&, const std::vector<output::AovImage>&)>;
  void render(const Taken& taken) {
    const std::vector<Group> groups = apart(objects_);
    const std::vector<IsolatedImage> images = imagesOf(groups);
    const uint64_t pixels = uint64_t{settings_.width} * settings_.height;
    const size_t most = std::clamp<uint64_t>(kPixelsAtOnce / pixels, 1, kMaxViews);
    std::optional<render::Ticket> before;
    for (size_t first = 0; first < images.size() + most; first += most) {
      const size_t end = std::min(first + most, images.size());
      std::optional<render::Ticket> now;
      if (first < end) now.emplace(submit(std::span(images).subspan(first, end - first)));
      if (before) {
        const std::vector<output::FrameOutput> pictures = before->take().frames;
        for (size_t i = 0; i < pictures.size(); ++i) {
          taken(images[first - most + i], pictures[i].aovs);
          renderer_.checkWhileWaiting();
        }
      }
      before = std::move(now);
    }
  }

 private:
  ScreenBounds boundsOf(size_t view, const Object& object) const {
    const ScreenBounds everywhere{ScreenBounds::Inside, 0, views_[view].size.x, 0, views_[view].size.y};
    if (render::bendsRays(cameras_[view])) return everywhere;
    const ScreenBounds bounds = screenBoundsOf(views_[view], viewFromPositions_[view] * object.toWorld, object);
    if (settings_.readout == 0) return bounds;
    // The bounds are those of the picture's time, and each row has a time of its own.
    ScreenBounds inTime = everywhere;
    if (bounds.containment != ScreenBounds::Inside) inTime.containment = ScreenBounds::Across;
    return inTime;
  }

  static std::vector<IsolatedImage> imagesOf(const std::vector<Group>& groups) {
    std::vector<IsolatedImage> images;
    for (uint32_t i = 0; i < groups.size(); ++i) {
      std::map<size_t, std::vector<Object*>> byView;
      for (const ObjectInViews* object : groups[i])
        for (const auto& [view, each] : *object)
          if (each.requested) byView[view].push_back(each.object);
      for (auto& [view, objects] : byView) images.push_back({i, static_cast<uint32_t>(view), std::move(objects)});
    }
    return images;
  }

  render::Ticket submit(std::span<const IsolatedImage> images) {
    const uint32_t first = images.front().group;
    std::unordered_map<uint32_t, uint32_t> groupOf;  // group number, from 1, by id
    for (const IsolatedImage& image : images)
      for (const Object* object : image.objects) groupOf[object->id] = image.group - first + 1;
    moment_.groups.assign(scene_.instances.size(), 0);
    for (size_t i = 0; i < scene_.instances.size(); ++i)
      if (const auto group = groupOf.find(scene_.instances[i].id); group != groupOf.end())
        moment_.groups[i] = group->second;
    std::vector<scene::Camera> cameras;
    for (const IsolatedImage& image : images) {
      cameras.push_back(cameras_[image.view]);
      cameras.back().group = image.group - first + 1;
    }
    render::SceneState state = moment_;
    for (auto* neighbors : {&state.previousCameras, &state.nextCameras})
      if (!neighbors->empty()) neighbors->assign(cameras.size(), neighbors->front());
    for (auto* seconds : {&state.motion.sincePrevious, &state.motion.untilNext})
      if (!seconds->empty()) seconds->assign(cameras.size(), seconds->front());
    if (const auto& cameraAt = moment_.motion.cameraAt)
      state.motion.cameraAt = [&cameraAt, cameras](size_t i, double seconds) {
        scene::Camera camera = cameraAt(0, seconds);  // a moment with such a function has one camera
        camera.group = cameras[i].group;
        return camera;
      };
    return renderer_.submit(cameras, settings_, state);
  }

  render::Renderer& renderer_;
  const scene::Scene& scene_;
  const std::vector<scene::Camera>& cameras_;
  render::Settings settings_;
  render::SceneState moment_;
  std::vector<shared::View> views_;  // of the cameras
  std::vector<glm::dmat4> viewFromPositions_;
  std::map<uint32_t, ObjectInViews> objects_;  // by id
};

void takeMasks(const IsolatedImage& image, const output::AovImage& ids) {
  std::map<uint32_t, Mask> masks = masksOf(ids);
  for (Object* object : image.objects) {
    const auto mask = masks.find(object->id);
    if (mask == masks.end()) continue;
    object->pixels = mask->second.area();
    object->full = mask->second.box();
    object->alone = std::move(mask->second);
  }
}

// Counts the pixels at which objects are in front of each other, from the distances of isolated objects.
class DepthOrder {
 public:
  void add(const IsolatedImage& image, const output::AovImage& ids, const output::AovImage& distances) {
    std::unordered_map<uint32_t, Object*> objects;
    for (Object* object : image.objects) objects[object->id] = object;
    for (uint32_t i = 0; i < ids.ids.size(); ++i)
      if (ids.ids[i] != 0) covered_.push_back({i, distances.values[i], objects.at(ids.ids[i])});
  }

  // Calls check() now and then: the time is quadratic in the number of objects that cover a pixel.
  void finish(const std::function<void()>& check) {
    constexpr uint64_t kPairsPerCheck = 1 << 14;
    uint64_t pairs = 0;
    std::ranges::sort(covered_, {}, [](const Covered& c) { return std::tuple(c.pixel, c.distance, c.object->id); });
    std::map<std::pair<Object*, uint32_t>, uint64_t> pixels;
    for (size_t i = 0; i < covered_.size(); ++i)
      for (size_t j = i + 1; j < covered_.size() && covered_[j].pixel == covered_[i].pixel; ++j) {
        if (covered_[i].distance < covered_[j].distance) ++pixels[{covered_[i].object, covered_[j].object->id}];
        if (++pairs % kPairsPerCheck == 0) check();
      }
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

// Returns the camera for a picture three times as wide and high around the camera's own picture.
scene::Camera widened(const scene::Camera& camera) {
  scene::Camera wide = camera;
  if (auto& lens = wide.lens) {  // a pinhole: it replaces the field of view and the principal point
    lens->cx += lens->width;
    lens->cy += lens->height;
    lens->width *= 3;
    lens->height *= 3;
    return wide;
  }
  wide.verticalFov = 2 * std::atan(3 * std::tan(camera.verticalFov / 2));
  wide.yHalf = 3 * camera.yHalf;
  wide.principal = camera.principal / 3.0f;
  return wide;
}

// Returns false for lenses that bend rays, and if the picture would be too large or the field of view too wide.
bool canWiden(const scene::Camera& camera, const render::Settings& settings) {
  if (render::bendsRays(camera) || 3 * std::max(settings.width, settings.height) > kWidest) return false;
  return camera.orthographic || camera.lens || scene::isUsableFieldOfView(widened(camera).verticalFov);
}

// Returns the settings of the enlarged picture. The rows of its central third have the times of the original rows.
render::Settings widened(const render::Settings& settings) {
  render::Settings large = settings;
  large.width *= 3;
  large.height *= 3;
  large.readout *= 3;
  return large;
}

// Returns the state of the scene for the enlarged picture. Only instantaneous pictures may have several cameras.
render::SceneState widened(const render::SceneState& moment, const std::vector<scene::Camera>& cameras,
                           const render::Settings& settings) {
  render::SceneState wide = render::onlyReadout(moment, settings);
  if (settings.readout == 0) return wide;
  const render::CameraMotion motion(cameras, wide.previousCameras, wide.nextCameras, wide.motion, settings);
  wide.previousCameras.clear();
  wide.nextCameras.clear();
  if (motion.movesCameras())
    wide.motion.cameraAt = [motion](size_t i, double seconds) { return widened(motion.at(i, seconds)); };
  return wide;
}

bool touchesEdge(const Mask& mask) {
  const PixelBox box = mask.box();
  return box.x == 0 || box.y == 0 || box.x + box.width == mask.width || box.y + box.height == mask.height;
}

PixelBox around(const PixelBox& a, const PixelBox& b) {
  if (a.width == 0) return b;
  const int64_t x = std::min(a.x, b.x), y = std::min(a.y, b.y);
  return {x, y, std::max(a.x + a.width, b.x + b.width) - x, std::max(a.y + a.height, b.y + b.height) - y};
}

// Adds the pixels that objects cover in the enlarged picture outside its central third, which is the original picture.
// An object of the group that does not cross the border of this view's picture may be visible, too, and is not counted.
void addBeyond(const IsolatedImage& image, const std::vector<output::AovImage>& pictures) {
  const output::AovImage& wide = pictures.front();
  std::unordered_map<uint32_t, Object*> objects;
  for (Object* object : image.objects) objects[object->id] = object;
  const uint32_t width = wide.width / 3, height = wide.height / 3;
  for (uint32_t y = 0; y < wide.height; ++y)
    for (uint32_t x = 0; x < wide.width; ++x) {
      const uint32_t id = wide.ids[size_t{y} * wide.width + x];
      const bool middle = x >= width && x < 2 * width && y >= height && y < 2 * height;
      const auto known = objects.find(id);
      if (middle || known == objects.end()) continue;
      Object& object = *known->second;
      ++object.pixels;
      object.full = around(object.full, {int64_t{x} - width, int64_t{y} - height, 1, 1});
    }
}

}  // namespace

void renderIsolated(render::Renderer& renderer, const scene::Scene& scene, const std::vector<scene::Camera>& cameras,
                    const render::Settings& settings, const render::SceneState& moment,
                    std::span<std::vector<Object>> objects, bool order) {
  IsolatedRenderer alone(renderer, scene, cameras, settings, moment, order);
  std::vector<std::pair<size_t, Object*>> across, inside;  // with their views
  for (size_t view = 0; view < cameras.size(); ++view)
    for (Object& object : objects[view]) {
      object.alone = {settings.width, settings.height, {settings.width * settings.height}};
      const bool isInside = alone.add(view, object) == ScreenBounds::Inside;
      (isInside ? inside : across).emplace_back(view, &object);
    }
  std::vector<DepthOrder> depths(cameras.size());
  alone.render([&](const IsolatedImage& image, const std::vector<output::AovImage>& pictures) {
    takeMasks(image, pictures.front());
    if (order) depths[image.view].add(image, pictures.front(), pictures.back());
  });
  for (DepthOrder& each : depths) each.finish([&] { renderer.checkWhileWaiting(); });
  std::vector<scene::Camera> wide;
  for (const scene::Camera& camera : cameras) wide.push_back(canWiden(camera, settings) ? widened(camera) : camera);
  IsolatedRenderer beyond(renderer, scene, wide, widened(settings), widened(moment, cameras, settings), false);
  // With a rolling shutter, objects that are inside at the picture's time can cross its border at another row's time.
  if (settings.readout != 0)
    for (const auto& each : inside)
      if (touchesEdge(each.second->alone)) across.push_back(each);
  for (const auto& [view, object] : across)
    if (object->alone.area() > 0 && canWiden(cameras[view], settings)) beyond.add(view, *object);
  for (const auto& [view, object] : across) beyond.avoid(view, *object);
  beyond.render(addBeyond);
}

void renderIsolated(render::Renderer& renderer, const scene::Scene& scene, const scene::Camera& camera,
                    const render::Settings& settings, const render::SceneState& moment, std::vector<Object>& objects,
                    bool order) {
  renderIsolated(renderer, scene, std::vector{camera}, settings, moment, std::span(&objects, 1), order);
}

}  // namespace latelight::labels
