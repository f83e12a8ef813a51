#include "render/reference_caster.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace latelight::render::test {

using glm::dvec2;
using glm::dvec3;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

#if RTC_VERSION_MAJOR >= 4
using QueryContext = RTCRayQueryContext;
#else
using QueryContext = RTCIntersectContext;
#endif

// Argument of the filter function besides the hit.
struct CastContext {
  QueryContext base;  // must come first: Embree passes on a pointer to it
  int* count;         // if set, the filter counts hits and lets the ray continue
};

// Embree 4 has the same query as Embree 3, with its arguments in a struct.
void intersect(RTCScene scene, CastContext& context, RTCRayHit& ray) {
#if RTC_VERSION_MAJOR >= 4
  rtcInitRayQueryContext(&context.base);
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = &context.base;
  rtcIntersect1(scene, &ray, &arguments);
#else
  rtcInitIntersectContext(&context.base);
  rtcIntersect1(scene, &context.base, &ray);
#endif
}

double wrapped(double u, scene::Wrap wrap) {
  switch (wrap) {
    case scene::Wrap::Repeat:
      return u - std::floor(u);
    case scene::Wrap::Mirror:
      return 1 - std::abs(u - 2 * std::floor(u / 2) - 1);
    case scene::Wrap::Clamp:
      return std::clamp(u, 0.0, 1.0);
  }
  return u;
}

// Alpha of the texel of mip level 0 at the coordinate.
double texelAlpha(const scene::Texture& texture, const scene::Sampler& sampler, dvec2 uv) {
  const auto index = [](double u, uint32_t size) { return std::min(static_cast<uint32_t>(u * size), size - 1); };
  const uint32_t x = index(wrapped(uv.x, sampler.wrapU), texture.width);
  const uint32_t y = index(wrapped(uv.y, sampler.wrapV), texture.height);
  return static_cast<double>(texture.pixels[4 * (size_t{y} * texture.width + x) + 3]) / 255.0;
}

template <typename T, typename F>
T blend(const std::array<uint32_t, 3>& corners, dvec3 weights, F&& value) {
  return weights.x * T(value(corners[0])) + weights.y * T(value(corners[1])) + weights.z * T(value(corners[2]));
}

}  // namespace

// An instance in world space: the data that Embree and the filter read.
struct ReferenceCaster::Surface {
  const scene::Scene* scene;
  const scene::Instance* instance;
  std::vector<glm::vec3> positions;

  const scene::Mesh& mesh() const { return scene->meshes[instance->mesh]; }
  const scene::Material& material() const { return scene->materials[instance->material]; }
  bool doubleSided() const { return material().data.flags & shared::kMaterialDoubleSided; }
  double handedness() const { return glm::determinant(glm::dmat3(instance->toWorld)) < 0 ? -1 : 1; }
  std::array<uint32_t, 3> corners(uint32_t triangle) const {
    const uint32_t* first = &mesh().indices[3 * size_t{triangle}];
    return {first[0], first[1], first[2]};
  }
  // The normal of the front side. Its length is twice the triangle's area.
  dvec3 areaNormal(uint32_t triangle) const {
    const auto [a, b, c] = corners(triangle);
    return handedness() *
           glm::cross(dvec3(positions[b]) - dvec3(positions[a]), dvec3(positions[c]) - dvec3(positions[a]));
  }
  bool masked(uint32_t triangle, dvec3 weights) const;
};

bool ReferenceCaster::Surface::masked(uint32_t triangle, dvec3 weights) const {
  const shared::Material& m = material().data;
  if (!(m.flags & shared::kMaterialMasked)) return false;
  const std::array<uint32_t, 3> abc = corners(triangle);
  double alpha = m.baseColor.a;
  if (!mesh().extras.empty())
    alpha *= blend<double>(abc, weights, [&](uint32_t i) { return mesh().extras[i].color.a; });
  const scene::TextureSlot& slot = material().slots[shared::kTextureBaseColor];
  if (slot.texture >= 0) {
    const shared::TextureTransform& t = m.transforms[shared::kTextureBaseColor];
    const dvec2 uv = blend<dvec2>(
        abc, weights, [&](uint32_t i) { return t.uvSet == 0 ? mesh().attributes[i].uv0 : mesh().extras[i].uv1; });
    const dvec3 homogeneous(uv, 1);
    alpha *= texelAlpha(scene->textures[size_t(slot.texture)], slot.sampler,
                        {glm::dot(dvec3(t.row0), homogeneous), glm::dot(dvec3(t.row1), homogeneous)});
  }
  return alpha < m.alphaCutoff;
}

void ReferenceCaster::filter(const RTCFilterFunctionNArguments* arguments) {
  const auto& surface = *static_cast<const Surface*>(arguments->geometryUserPtr);
  RTCRayN* ray = arguments->ray;
  RTCHitN* hit = arguments->hit;
  const uint32_t triangle = RTCHitN_primID(hit, 1, 0);
  const dvec3 direction(RTCRayN_dir_x(ray, 1, 0), RTCRayN_dir_y(ray, 1, 0), RTCRayN_dir_z(ray, 1, 0));
  const bool front = glm::dot(surface.areaNormal(triangle), direction) < 0;
  const double u = RTCHitN_u(hit, 1, 0), v = RTCHitN_v(hit, 1, 0);
  const bool seen = (front || surface.doubleSided()) && !surface.masked(triangle, {1 - u - v, u, v});
  int* count = reinterpret_cast<const CastContext*>(arguments->context)->count;
  if (count && seen) ++*count;
  if (count || !seen) arguments->valid[0] = 0;
}

ReferenceCaster::ReferenceCaster(const scene::Scene& scene, const scene::Camera& camera, uint32_t width,
                                 uint32_t height)
    : camera_(camera), width_(width), height_(height), eye_(camera.toWorld[3]) {
  for (int i = 0; i < 3; ++i) axes_[i] = glm::normalize(dvec3(camera.toWorld[i]));
  const double up = camera.orthographic ? camera.yHalf : std::tan(0.5 * camera.verticalFov);
  scale_ = {up * width / height, up};

  device_ = rtcNewDevice(nullptr);
  embree_ = rtcNewScene(device_);
  rtcSetSceneFlags(embree_, RTC_SCENE_FLAG_ROBUST);
  for (const scene::Instance& instance : scene.instances) {
    Surface& surface = *surfaces_.emplace_back(std::make_unique<Surface>(Surface{&scene, &instance, {}}));
    const scene::Mesh& mesh = surface.mesh();
    for (glm::vec3 p : mesh.positions) surface.positions.push_back(glm::mat4x3(instance.toWorld) * glm::vec4(p, 1));
    surface.positions.emplace_back();  // Embree reads 16 bytes at every vertex
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, surface.positions.data(), 0,
                               sizeof(glm::vec3), mesh.positions.size());
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.indices.data(), 0,
                               3 * sizeof(uint32_t), mesh.indices.size() / 3);
    rtcSetGeometryUserData(geometry, &surface);
    rtcSetGeometryIntersectFilterFunction(geometry, filter);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(embree_, geometry, static_cast<unsigned>(surfaces_.size() - 1));
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(embree_);
  markEdges();
}

ReferenceCaster::~ReferenceCaster() {
  rtcReleaseScene(embree_);
  rtcReleaseDevice(device_);
}

ReferenceCaster::Ray ReferenceCaster::rayThrough(dvec2 pixel) const {
  const dvec2 ndc(2 * pixel.x / width_ - 1 - camera_.principal.x, 1 - 2 * pixel.y / height_ - camera_.principal.y);
  const dvec3 across = axes_[0] * (ndc.x * scale_.x) + axes_[2] * (ndc.y * scale_.y);
  if (camera_.orthographic) return {eye_ + across, axes_[1]};
  return {eye_, axes_[1] + across};
}

namespace {

RTCRayHit embreeRay(dvec3 origin, dvec3 direction, double near, double far) {
  RTCRayHit r{};
  r.ray.org_x = float(origin.x), r.ray.org_y = float(origin.y), r.ray.org_z = float(origin.z);
  r.ray.dir_x = float(direction.x), r.ray.dir_y = float(direction.y), r.ray.dir_z = float(direction.z);
  r.ray.tnear = float(near), r.ray.tfar = float(far);
  r.ray.mask = ~0u;
  r.hit.geomID = r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return r;
}

}  // namespace

std::optional<Hit> ReferenceCaster::cast(dvec2 pixel) const {
  return cast(rayThrough(pixel));
}

std::optional<Hit> ReferenceCaster::castAlong(dvec3 direction) const {
  return cast(Ray{eye_, axes_ * direction});
}

std::optional<Hit> ReferenceCaster::cast(const Ray& ray) const {
  RTCRayHit r = embreeRay(ray.origin, ray.direction, camera_.nearClip, camera_.farClip);
  CastContext context{{}, nullptr};
  intersect(embree_, context, r);
  if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return refine(ray, r.hit.geomID, r.hit.primID);
}

int ReferenceCaster::surfacesNear(dvec2 pixel, double depth, double tolerance) const {
  const Ray ray = rayThrough(pixel);
  RTCRayHit r = embreeRay(ray.origin, ray.direction, depth * (1 - tolerance), depth * (1 + tolerance));
  int count = 0;
  CastContext context{{}, &count};
  intersect(embree_, context, r);
  return count;
}

double ReferenceCaster::freeDistance(dvec3 origin, dvec3 direction, double farthest) const {
  RTCRayHit r = embreeRay(origin, direction, 1e-4 * farthest, farthest);
  CastContext context{{}, nullptr};
  intersect(embree_, context, r);
  return r.hit.geomID == RTC_INVALID_GEOMETRY_ID ? kInfinity : double{r.ray.tfar};
}

// Intersects the ray with the triangle's plane and interpolates the attributes at that point.
Hit ReferenceCaster::refine(const Ray& ray, uint32_t index, uint32_t triangle) const {
  const Surface& surface = *surfaces_[index];
  const std::array<uint32_t, 3> abc = surface.corners(triangle);
  const dvec3 a(surface.positions[abc[0]]), b(surface.positions[abc[1]]), c(surface.positions[abc[2]]);
  const dvec3 n = surface.areaNormal(triangle);
  const double facing = glm::dot(n, ray.direction) < 0 ? 1 : -1;

  Hit hit{.instance = index, .triangle = triangle, .part = surface.instance->part};
  hit.depth = glm::dot(n, a - ray.origin) / glm::dot(n, ray.direction);
  hit.position = ray.origin + hit.depth * ray.direction;
  hit.distance = hit.depth * glm::length(ray.direction);
  hit.geonormal = facing * glm::normalize(n);
  const double area2 = glm::dot(n, n) * surface.handedness();
  const dvec3 weights(glm::dot(n, glm::cross(c - b, hit.position - b)) / area2,
                      glm::dot(n, glm::cross(a - c, hit.position - c)) / area2,
                      glm::dot(n, glm::cross(b - a, hit.position - a)) / area2);
  const auto& attributes = surface.mesh().attributes;
  hit.uv = blend<dvec2>(abc, weights, [&](uint32_t i) { return attributes[i].uv0; });
  const dvec3 objectNormal = blend<dvec3>(abc, weights, [&](uint32_t i) { return attributes[i].normal; });
  const glm::dmat3 linear(surface.instance->toWorld);
  hit.normal = facing * glm::normalize(glm::transpose(glm::inverse(linear)) * objectNormal);

  const double longest = std::max({glm::length(b - a), glm::length(c - b), glm::length(a - c)});
  const double coordinate = std::max({glm::length(a), glm::length(b), glm::length(c)});
  hit.flatness = glm::length(n) / longest / coordinate;
  const double pixelSize = 2 * scale_.y / height_ * (camera_.orthographic ? 1 : hit.depth);
  const double cosine = std::abs(glm::dot(hit.geonormal, glm::normalize(ray.direction)));
  const double crossed = pixelSize / std::max(cosine, 1e-6) / (glm::length(n) / longest);  // relative to the triangle
  const auto extent = [&](auto&& value) {
    return std::max({glm::length(value(abc[1]) - value(abc[0])), glm::length(value(abc[2]) - value(abc[1])),
                     glm::length(value(abc[0]) - value(abc[2]))});
  };
  hit.uvPerPixel = crossed * extent([&](uint32_t i) { return attributes[i].uv0; });
  hit.normalPerPixel = crossed * extent([&](uint32_t i) { return attributes[i].normal; });
  return hit;
}

dvec3 ReferenceCaster::project(dvec3 view) const {
  const double w = camera_.orthographic ? 1 : view.y;
  const dvec2 ndc(view.x / (scale_.x * w) + camera_.principal.x, view.z / (scale_.y * w) + camera_.principal.y);
  return {(ndc.x + 1) * 0.5 * width_, (1 - ndc.y) * 0.5 * height_, view.y};
}

void ReferenceCaster::markEdges() {
  edges_.assign(size_t{width_} * height_, kInfinity);
  const glm::dmat3 toView = glm::transpose(axes_);
  for (const auto& surface : surfaces_) {
    for (uint32_t triangle = 0; triangle < surface->mesh().indices.size() / 3; ++triangle) {
      const std::array<uint32_t, 3> corners = surface->corners(triangle);
      const dvec3 ray = camera_.orthographic ? axes_[1] : dvec3(surface->positions[corners[0]]) - eye_;
      if (!surface->doubleSided() && glm::dot(surface->areaNormal(triangle), ray) > 0) continue;
      for (int i = 0; i < 3; ++i)
        markEdge(toView * (dvec3(surface->positions[corners[i]]) - eye_),
                 toView * (dvec3(surface->positions[corners[(i + 1) % 3]]) - eye_));
    }
  }
}

// Marks the pixels whose center the edge passes within kEdgeReach. Along the edge's major axis, only the nearest center
// of each row or column can be within reach, because the reach is much less than half a pixel.
void ReferenceCaster::markEdge(dvec3 a, dvec3 b) {
  const double near = camera_.nearClip;
  if (a.y < near && b.y < near) return;
  if (a.y < near) a = glm::mix(a, b, (near - a.y) / (b.y - a.y));
  if (b.y < near) b = glm::mix(b, a, (near - b.y) / (a.y - b.y));
  a = project(a), b = project(b);
  const int major = std::abs(b.x - a.x) >= std::abs(b.y - a.y) ? 0 : 1, minor = 1 - major;
  if (a[major] > b[major]) std::swap(a, b);
  const dvec2 along(b - a);
  const double length2 = glm::dot(along, along);
  const uint32_t limit = major == 0 ? width_ : height_, minorLimit = major == 0 ? height_ : width_;
  const double first = std::max(std::ceil(a[major] - kEdgeReach - 0.5), 0.0);
  const double last = std::min(std::floor(b[major] + kEdgeReach - 0.5), limit - 1.0);
  for (double i = first; i <= last; ++i) {
    dvec2 center;
    center[major] = i + 0.5;
    const double t0 = length2 > 0 ? std::clamp((center[major] - a[major]) / (b[major] - a[major]), 0.0, 1.0) : 0;
    const double row = std::floor(glm::mix(a[minor], b[minor], t0));
    if (!(row >= 0 && row < minorLimit)) continue;
    center[minor] = row + 0.5;
    const double t = length2 > 0 ? std::clamp(glm::dot(center - dvec2(a), along) / length2, 0.0, 1.0) : 0;
    if (glm::length(dvec2(a) + t * along - center) > kEdgeReach) continue;
    const double depth = camera_.orthographic ? glm::mix(a.z, b.z, t) : 1 / glm::mix(1 / a.z, 1 / b.z, t);
    double& nearest = edges_[static_cast<size_t>(center.y) * width_ + static_cast<size_t>(center.x)];
    nearest = std::min(nearest, depth);
  }
}

}  // namespace latelight::render::test
