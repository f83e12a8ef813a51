// Generates the hall's lights, from one to a million, always with the same exposure.
//
// The first hundred are in the hall's lamps. Further ones are small and scattered evenly over its surfaces at a small
// distance. Their range shrinks as their number grows, so that about the same number reaches any point. By default few
// lights cast shadows, so ranges also limit light leaking through walls.
#include <algorithm>
#include <array>

#include "base/parallel.h"
#include "scene/builtin/hall/hall.h"
#include "scene/builtin/random.h"
#include "shared/light.h"

namespace latelight::scene::builtin::hall {
namespace {

// A point on an approximate flat or round region of the hall's surface, for scattering lights and metering exposure.
struct Spot {
  dvec3 position, normal;  // in glTF's frame
};

struct Region {
  double area;
  Spot (*at)(double u, double v);
};

double mixed(double a, double b, double t) {
  return a + (b - a) * t;
}

// Returns the side of the hall, 1 or -1, and remaps u to [0, 1] within it; u >= 1/2 selects the left side.
double sideOf(double& u) {
  const double side = u < 0.5 ? 1 : -1;
  u = u < 0.5 ? 2 * u : 2 * u - 1;
  return side;
}

double alongHall(double v) {
  return mixed(-kHalfLength, kHalfLength, v);
}

constexpr double kLength = 2 * kHalfLength;
const Region kRegions[] = {
    {2 * kOuterX * kLength,
     [](double u, double v) {
       return Spot{{mixed(-kOuterX, kOuterX, u), 0, alongHall(v)}, {0, 1, 0}};
     }},
    {kPi * kVaultRadius * kLength,
     [](double u, double v) {
       const dvec2 cs = onCircle(0.5 * u);
       return Spot{{kVaultRadius * cs.x, kVaultSpring + kVaultRadius * cs.y, alongHall(v)}, {-cs.x, -cs.y, 0}};
     }},
    {2 * (kVaultSpring - kArcadeTop + 1.5) * kLength,
     [](double u, double v) {
       const double side = sideOf(u);
       return Spot{{side * kNaveX, mixed(kArcadeTop - 1.5, kVaultSpring, u), alongHall(v)}, {-side, 0, 0}};
     }},
    {2 * kGalleryTop * kLength,
     [](double u, double v) {
       const double side = sideOf(u);
       return Spot{{side * kOuterX, mixed(0, kGalleryTop, u), alongHall(v)}, {-side, 0, 0}};
     }},
    {4 * kAisleHalf * kLength,
     [](double u, double v) {
       const double side = sideOf(u);
       return Spot{
           {side * mixed(kAisleX - kAisleHalf, kAisleX + kAisleHalf, u), kArchSpring + 0.8 * kAisleRise, alongHall(v)},
           {0, -1, 0}};
     }},
    {2 * (kBays + 1) * kTau * kColumnRadius * kArchSpring,
     [](double u, double v) {
       const double side = sideOf(u);
       const int column = std::min(kBays, static_cast<int>(v * (kBays + 1)));
       const double turn = v * (kBays + 1) - column;
       const dvec2 cs = onCircle(turn);
       return Spot{
           {side * kColumnX + kColumnRadius * cs.x, kArchSpring * u, bayBoundary(column) + kColumnRadius * cs.y},
           {cs.x, 0, cs.y}};
     }},
    {kTau * kApseRadius * kApseSpring / 2 + kPi * kApseRadius * kApseRadius,
     [](double u, double v) {
       const dvec2 cs = onCircle(0.5 * u);
       const double y = (kApseSpring + 0.7 * kApseRadius) * v;
       const double r =
           y < kApseSpring ? kApseRadius : std::sqrt(kApseRadius * kApseRadius - (y - kApseSpring) * (y - kApseSpring));
       const dvec3 p(r * cs.x, y, -kHalfLength - r * cs.y);
       const dvec3 center(0, std::min(y, kApseSpring), -kHalfLength);
       return Spot{p, glm::normalize(center - p)};
     }},
};

double regionsArea() {
  double area = 0;
  for (const Region& region : kRegions) area += region.area;
  return area;
}

Spot randomSpot(Random& random) {
  double at = random.unit() * regionsArea();
  const double u = random.unit(), v = random.unit();
  for (const Region& region : kRegions) {
    if (at < region.area) return region.at(u, v);
    at -= region.area;
  }
  return kRegions[0].at(u, v);
}

vec3 inWorld(dvec3 gltf) {
  return {gltf.x, -gltf.z, gltf.y};
}

Light pointLight(const char* name, vec3 position, vec3 color, double intensity, double range) {
  Light light;
  light.name = name;
  light.position = position;
  light.color = color;
  light.intensity = static_cast<float>(intensity);
  light.range = static_cast<float>(range);
  return light;
}

// Orders lamps such that the first n are spread out over the hall for any n: each lamp is the farthest from the earlier
// ones (farthest-point sampling).
std::vector<size_t> spreadOrder(const std::vector<LampSite>& lamps) {
  const vec3 start = inWorld({0, kVaultSpring - 3, 9});  // near the first lamp, in the main camera's view
  std::vector<float> nearest(lamps.size());
  for (size_t i = 0; i < lamps.size(); ++i) nearest[i] = 1e6f - glm::length(lamps[i].position - start);
  std::vector<size_t> order;
  while (order.size() < lamps.size()) {
    const size_t next = static_cast<size_t>(std::max_element(nearest.begin(), nearest.end()) - nearest.begin());
    order.push_back(next);
    for (size_t i = 0; i < lamps.size(); ++i)
      nearest[i] = std::min(nearest[i], glm::length(lamps[i].position - lamps[next].position));
    nearest[next] = -1;
  }
  return order;
}

// Radius in meters that encloses the glass of any lamp.
constexpr float kGlassRadius = 0.24f;

void addLampLights(HallBuilder& hall, uint32_t count) {
  Scene& scene = hall.builder.scene;
  const double reach = std::clamp(std::sqrt(double(hall.lamps.size()) / count), 1.0, 6.0);
  const std::vector<size_t> order = spreadOrder(hall.lamps);
  for (uint32_t i = 0; i < count; ++i) {
    const LampSite& lamp = hall.lamps[order[i]];
    scene.lights.push_back(pointLight("lamp", lamp.position, lamp.color, lamp.weight, lamp.range * reach));
    scene.lights.back().size = kGlassRadius;
    if (lamp.instance != kNoInstance)
      scene.instances[lamp.instance].material = static_cast<uint32_t>(HallMaterial::LampGlass);
  }
}

vec3 smallColor(Random& random) {
  static constexpr std::array<vec3, 6> kColors{{{1, 0.62f, 0.28f},
                                                {1, 0.72f, 0.45f},
                                                {1, 0.5f, 0.2f},
                                                {1, 0.42f, 0.3f},
                                                {0.35f, 0.75f, 0.9f},
                                                {0.5f, 0.55f, 1}}};
  const double pick = random.unit();
  const size_t i = pick < 0.34 ? 0 : pick < 0.6 ? 1 : pick < 0.8 ? 2 : pick < 0.88 ? 3 : pick < 0.95 ? 4 : 5;
  return kColors[i];
}

// The approximate number of small lights within range of each surface point.
constexpr double kOverlap = 14;

// `illuminance` is the average contribution of the small lights to the hall's surfaces, before exposure.
void addSmallLights(HallBuilder& hall, uint32_t count, double illuminance) {
  Scene& scene = hall.builder.scene;
  const double density = count / regionsArea();
  const double range = std::min(2.5, std::sqrt(kOverlap / (kPi * density)));
  const double off = 0.35 * range;
  // A light of 1 cd at this distance sends about half of its 2 pi lm towards the surface to points within its range.
  const double intensity = std::min(illuminance / (density * kPi), illuminance * 2 * off * off);
  scene.lights.resize(scene.lights.size() + count);
  Light* lights = scene.lights.data() + scene.lights.size() - count;
  parallelFor(count, 8192, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      Random random(hall.seed, 1000 + static_cast<uint32_t>(i));
      const Spot spot = randomSpot(random);
      const double share = random.between(0.5, 1.5);
      lights[i] = pointLight("spark", inWorld(spot.position + spot.normal * (off * random.between(0.7, 1.3))),
                             smallColor(random), intensity * share, range);
    }
  });
}

// Returns the point where a ray of the main camera's view hits the hall, which is approximated by floor, walls and
// vault without columns.
Spot firstWall(dvec3 eye, dvec3 d) {
  double nearest = 1e9;
  Spot spot{};
  const auto meet = [&](double t, dvec3 normal) {
    if (t > 1e-6 && t < nearest) {
      nearest = t;
      spot = {eye + d * t, normal};
    }
  };
  if (d.y < 0) meet(-eye.y / d.y, {0, 1, 0});
  if (d.z < 0) meet((-kHalfLength - eye.z) / d.z, {0, 0, 1});
  const double side = d.x < 0 ? -1 : 1, wall = (side * kNaveX - eye.x) / d.x;
  if ((eye + d * wall).y > kArchSpring + 0.7 * kArchRadius) meet(wall, {-side, 0, 0});
  meet((side * kOuterX - eye.x) / d.x, {-side, 0, 0});
  const double y = eye.y - kVaultSpring, a = d.x * d.x + d.y * d.y, b = eye.x * d.x + y * d.y;
  const double c = eye.x * eye.x + y * y - kVaultRadius * kVaultRadius;
  const double crown = (-b + std::sqrt(std::max(0.0, b * b - a * c))) / a;
  const dvec3 p = eye + d * crown;
  if (p.y > kVaultSpring) meet(crown, glm::normalize(dvec3(-p.x, kVaultSpring - p.y, 0)));
  return spot;
}

std::vector<Spot> meteredSpots(const Camera& camera) {
  const glm::dmat4 toGltf = glm::dmat4(toGltfFromWorld()) * glm::dmat4(camera.toWorld);
  const double v = 0.534, h = v * 16 / 9;  // tangents of half the field of view, approximately the main camera's
  std::vector<Spot> spots;
  for (int j = 0; j < 12; ++j) {
    for (int i = 0; i < 20; ++i) {
      const glm::dvec4 d = toGltf * glm::dvec4(((i + 0.5) / 10 - 1) * h, 1, (1 - (j + 0.5) / 6) * v, 0);
      spots.push_back(firstWall(dvec3(toGltf[3]), glm::normalize(dvec3(d))));
    }
  }
  return spots;
}

// The data of the range test, packed, because most lights reach none of the metered spots.
struct Reach {
  vec3 position;
  float range2;
};

std::vector<Reach> reachesOf(const std::vector<Light>& lights) {
  std::vector<Reach> reaches;
  reaches.reserve(lights.size());
  for (const Light& light : lights) reaches.push_back({light.position, *light.range * *light.range});
  return reaches;
}

// Illuminance in lux, weighted by luminance.
double illuminanceAt(const std::vector<Light>& lights, const std::vector<Reach>& reaches, const Spot& spot) {
  const vec3 position = inWorld(spot.position), normal = inWorld(spot.normal);
  double sum = 0;
  for (size_t i = 0; i < reaches.size(); ++i) {
    const vec3 to = reaches[i].position - position;
    const float distance2 = glm::dot(to, to), facing = glm::dot(to, normal);
    if (distance2 >= reaches[i].range2 || facing <= 0) continue;
    const Light& light = lights[i];
    const float window = shared::lightWindow(distance2, shared::inverseRadius2(*light.range));
    sum +=
        double(light.intensity) * shared::luminance(light.color) * window * facing / (distance2 * std::sqrt(distance2));
  }
  return sum;
}

std::vector<double> illuminances(const Scene& scene) {
  const std::vector<Spot> spots = meteredSpots(scene.cameras.front());
  const std::vector<Reach> reaches = reachesOf(scene.lights);
  std::vector<double> result(spots.size());
  parallelFor(spots.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) result[i] = illuminanceAt(scene.lights, reaches, spots[i]);
  });
  return result;
}

// Scales all lights such that the main camera's view has about this average brightness. Radiance above kWhite is
// clamped.
constexpr double kMeanRadiance = 0.28, kAlbedo = 0.5, kWhite = 0.8;

void expose(Scene& scene) {
  std::vector<double> radiance = illuminances(scene);
  for (double& r : radiance) r *= kAlbedo / kPi;
  double low = -40, high = 40;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high), scale = exponential2(middle);
    double sum = 0;
    for (const double r : radiance) sum += std::min(r * scale, kWhite);
    (sum < kMeanRadiance * double(radiance.size()) ? low : high) = middle;
  }
  const float scale = static_cast<float>(exponential2(low));
  for (Light& light : scene.lights) light.intensity *= scale;
}

}  // namespace

void addLights(HallBuilder& hall, uint32_t count) {
  Scene& scene = hall.builder.scene;
  const uint32_t lamps = std::min(count, static_cast<uint32_t>(hall.lamps.size()));
  addLampLights(hall, lamps);
  if (count > lamps) {
    const std::vector<double> lit = illuminances(scene);
    double sum = 0;
    for (const double e : lit) sum += e;
    addSmallLights(hall, count - lamps, 1.5 * sum / double(lit.size()));
  }
  expose(scene);
}

}  // namespace latelight::scene::builtin::hall
