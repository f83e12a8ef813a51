// The error of finished images against the reference (light_truth.h): spheres of many materials and roughnesses under
// each kind of light, at selected pixels, each with its own normal and view direction.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>

#include "base/error.h"
#include "base/parallel.h"
#include "render/submit/renderer.h"
#include "scene/builtin/builtin.h"
#include "scene/environment/filter.h"
#include "scene/load/load.h"
#include "shared/light.h"
#include "study/light_truth.h"
#include "study/study.h"

namespace latelight::study {

namespace {

using glm::dvec3;
using glm::vec3;
using output::Aov;

// --- subjects --------------------------------------------------------------------------------------------------------

enum Kind { Dielectric, Grey, Coloured };
constexpr const char* kKinds[] = {"dielectric", "gray metal", "colored metal"};
struct NamedMaterial {
  const char* name;
  Kind kind;
  vec3 baseColor;
  float metallic;
};
constexpr NamedMaterial kMaterials[scene::kSpheresRows] = {{"white dielectric", Dielectric, {0.8f, 0.8f, 0.8f}, 0},
                                                           {"black dielectric", Dielectric, {0.02f, 0.02f, 0.02f}, 0},
                                                           {"iron", Grey, {0.56f, 0.57f, 0.58f}, 1},
                                                           {"gold", Coloured, {1, 0.78f, 0.34f}, 1},
                                                           {"red metal", Coloured, {0.9f, 0.2f, 0.15f}, 1}};
constexpr float kRoughness[scene::kSpheresColumns] = {0, 0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f, 0.8f, 1};

// Loads builtin:spheres with one material per row and one roughness per column.
scene::Scene spheres() {
  scene::Scene scene = scene::load("builtin:spheres");
  for (uint32_t i = 0; i < scene.materials.size(); ++i) {
    const NamedMaterial& m = kMaterials[i / scene::kSpheresColumns];
    shared::Material& data = scene.materials[i].data;
    data.baseColor = glm::vec4(m.baseColor, 1);
    data.metallic = m.metallic;
    data.roughness = kRoughness[i % scene::kSpheresColumns];
  }
  return scene;
}

// --- lights ----------------------------------------------------------------------------------------------------------

struct NamedEnvironment {
  std::string name;
  scene::Environment environment;
};

scene::Environment environmentOf(uint32_t height, vec3 (*radiance)(vec3 direction)) {
  scene::FloatImage picture(2 * height, height);
  for (uint32_t y = 0; y < height; ++y) {
    const float polar = (float(y) + 0.5f) * shared::kPi / float(height);
    for (uint32_t x = 0; x < 2 * height; ++x) {
      const float turn = ((float(x) + 0.5f) / float(2 * height) - 0.5f) * 2 * shared::kPi;
      const vec3 light =
          radiance({std::sin(polar) * std::cos(turn), -std::sin(polar) * std::sin(turn), std::cos(polar)});
      std::copy_n(&light.x, 3, picture.at(x, y));
    }
  }
  return scene::filterEnvironment(std::move(picture));
}

// World space: z is up, and the spheres are seen from -y.
vec3 sunInTheDark(vec3 d) {
  const bool sun = glm::dot(d, glm::normalize(vec3(0.5f, -0.6f, 0.6f))) > std::cos(0.04f);
  return sun ? vec3(400, 380, 350) : vec3(0.05f, 0.07f, 0.1f) * (0.6f + 0.4f * d.z);
}
vec3 halfWhite(vec3 d) {
  return vec3(d.x > 0 ? 1.0f : 0.0f);
}
vec3 gradient(vec3 d) {
  return vec3(0.5f) + vec3(0.4f, 0.2f, -0.1f) * d.z + vec3(0.1f, -0.2f, 0.3f) * d.x;
}
vec3 white(vec3) {
  return vec3(1);
}

std::vector<NamedEnvironment> environments(const std::vector<std::string>& files) {
  std::vector<NamedEnvironment> all;
  all.push_back({"white room", environmentOf(64, white)});
  all.push_back({"gradient", environmentOf(64, gradient)});
  all.push_back({"studio", scene::loadEnvironment("studio")});
  all.push_back({"half white, half black", environmentOf(128, halfWhite)});
  all.push_back({"sun in the dark", environmentOf(256, sunInTheDark)});
  for (const std::string& file : files) {
    scene::Environment environment = scene::loadEnvironment(file);
    all.push_back({environment.name, std::move(environment)});
  }
  return all;
}

std::vector<scene::Light> punctualLights() {
  scene::Light directional;
  directional.name = "directional light";
  directional.type = shared::kLightDirectional;
  directional.direction = glm::normalize(vec3(-0.5f, 0.8f, -0.6f));
  directional.intensity = 3;
  scene::Light point;
  point.name = "point light";
  point.position = {2, -4, 2};
  point.intensity = 60;
  scene::Light spot = point;
  spot.name = "spot light";
  spot.type = shared::kLightSpot;
  spot.direction = glm::normalize(vec3(-2, 4, -2));
  spot.innerCone = 0.4f, spot.outerCone = 0.7f;
  return {directional, point, spot};
}

// Returns the irradiance at `position` at normal incidence (KHR_lights_punctual), without a range.
double illuminance(const scene::Light& light, const dvec3& position, dvec3& toLight) {
  if (light.type == shared::kLightDirectional) {
    toLight = -dvec3(light.direction);
    return light.intensity;
  }
  const dvec3 offset = dvec3(light.position) - position;
  toLight = glm::normalize(offset);
  double result = light.intensity / glm::dot(offset, offset);
  if (light.type == shared::kLightSpot) {
    const double outer = std::cos(double{light.outerCone}), inner = std::cos(double{light.innerCone});
    const double cone =
        std::clamp((-glm::dot(dvec3(light.direction), toLight) - outer) / std::max(0.001, inner - outer), 0.0, 1.0);
    result *= cone * cone;
  }
  return result;
}

// --- pixels ---------------------------------------------------------------------------------------------------------

constexpr uint32_t kWidth = 468, kHeight = 260;  // a sphere is about 45 pixels wide
// Pixels per sphere with n.v of at least 0.5 and with less: three to one, as in the image of a sphere.
constexpr size_t kFacing = 27, kGrazing = 9;

constexpr uint32_t kWalks = 20;  // per sample: walks are fast, and all environments share them

struct Pixel {
  shared::Surface surface;
  dvec3 toEye, radiance;
  size_t material, roughness;
  bool grazing;
};

struct ErrorGroup {
  size_t light;
  Kind kind;
  size_t band;  // roughness band
  bool grazing;
  auto operator<=>(const ErrorGroup&) const = default;
};
struct Errors {
  double sum = 0, worst = 0;
  size_t count = 0;
  void add(double error) { sum += error, worst = std::max(worst, error), ++count; }
};

constexpr const char* kBands[] = {"0 to 0.2", "0.3 to 0.6", "0.8 to 1"};
size_t bandOf(float roughness) {
  return roughness < 0.25f ? 0 : roughness < 0.7f ? 1 : 2;
}

// Appends up to `wanted` elements, evenly spaced.
template <typename T>
void takeSpread(std::vector<T>& to, const std::vector<T>& from, size_t wanted) {
  for (size_t i = 0; i < std::min(wanted, from.size()); ++i)
    to.push_back(from[i * from.size() / std::min(wanted, from.size())]);
}

class AccuracyStudy {
 public:
  explicit AccuracyStudy(const Options& options)
      : device_({.selector = options.device, .validation = options.validation}),
        samples_(std::max(options.samples / 1000, 64u)),
        files_(options.environments) {}

  Result run() {
    for (const scene::Light& light : punctualLights()) measure(light);
    for (const NamedEnvironment& environment : environments(files_)) measure(environment);
    for (const std::string& message : device_.validationMessages())
      fail(ExitCode::Internal, "the Vulkan validation layer says: {}", message);
    return {device_.info().name, {summary(), table()}, {}, {}};
  }

 private:
  void measure(const scene::Light& light) {
    scene::Scene scene = spheres();
    scene.lights = {light};
    const std::vector<Pixel> pixels = read(scene, nullptr);
    judge(light.name, pixels, [&](const Pixel& p) {
      dvec3 toLight;
      const double lux = illuminance(light, dvec3(p.surface.position), toLight);
      const double cosine = glm::dot(glm::normalize(dvec3(p.surface.normal)), toLight);
      return gltfBrdf(p.surface, toLight, p.toEye) * (lux * std::max(cosine, 0.0));
    });
  }

  void measure(const NamedEnvironment& named) {
    const scene::Scene scene = spheres();
    const std::vector<Pixel> pixels = read(scene, &named.environment);
    const EnvironmentTruth truth(toFloats(named.environment.radiance));
    if (bounces_.empty()) walk(pixels);
    judge(named.name, pixels, [&](const Pixel& p) {
      return truth.radiance(p.surface, p.toEye, bounces_[size_t(&p - pixels.data())], samples_);
    });
  }

  // All environments use the same pixels, so they share the walks.
  void walk(const std::vector<Pixel>& pixels) {
    std::vector<std::optional<Bounces>> found(pixels.size());
    parallelFor(pixels.size(), 4, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) found[i].emplace(pixels[i].surface, pixels[i].toEye, kWalks * samples_);
    });
    for (std::optional<Bounces>& bounces : found) bounces_.push_back(std::move(*bounces));
  }

  std::vector<Pixel> read(const scene::Scene& scene, const scene::Environment* environment) {
    render::Settings settings;
    settings.width = kWidth, settings.height = kHeight;
    settings.layout = &render::findLayout("exact");
    settings.shadows = render::ShadowFormat::None;
    settings.display = false;
    settings.aovs = {Aov::Color, Aov::Normal, Aov::Position, Aov::Id};
    settings.axes = render::Axes::ZUp;
    render::Renderer renderer(device_, scene, environment);
    const scene::Camera& camera = scene.cameras.front();
    const output::FrameOutput frame = std::move(renderer.render(std::span(&camera, 1), settings).front());
    return choose(scene, frame, dvec3(camera.toWorld[3]));
  }

  static std::vector<Pixel> choose(const scene::Scene& scene, const output::FrameOutput& frame, const dvec3& eye) {
    const auto& color = frame.aovs[0].values;
    const auto& ids = frame.aovs[3].ids;
    const auto vector = [&](size_t aov, size_t i) {
      const float* v = frame.aovs[aov].values.data() + 3 * i;
      return vec3(v[0], v[1], v[2]);
    };
    std::vector<Pixel> pixels;
    for (const scene::Instance& instance : scene.instances) {
      std::vector<Pixel> facing, grazing;
      for (size_t i = 0; i < ids.size(); ++i) {
        if (ids[i] != instance.id) continue;
        Pixel p{shared::emptySurface()};
        p.surface.normal = vector(1, i), p.surface.position = vector(2, i);
        const shared::Material& m = scene.materials[instance.material].data;
        p.surface.baseColor = vec3(m.baseColor), p.surface.metallic = m.metallic, p.surface.roughness = m.roughness;
        p.surface.f0 = vec3(m.f0), p.surface.f90 = 1;
        p.toEye = glm::normalize(eye - dvec3(p.surface.position));
        p.radiance = dvec3(color[4 * i], color[4 * i + 1], color[4 * i + 2]);
        p.material = instance.material / scene::kSpheresColumns;
        p.roughness = instance.material % scene::kSpheresColumns;
        const double nv = glm::dot(dvec3(p.surface.normal), p.toEye);
        p.grazing = nv < 0.5;
        if (nv > 0.02) (p.grazing ? grazing : facing).push_back(p);
      }
      takeSpread(pixels, facing, kFacing);
      takeSpread(pixels, grazing, kGrazing);
    }
    return pixels;
  }

  template <typename Truth>
  void judge(const std::string& light, const std::vector<Pixel>& pixels, Truth truth) {
    std::vector<dvec3> errors(pixels.size());
    parallelFor(pixels.size(), 16, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        const dvec3 expected = truth(pixels[i]);
        for (int c = 0; c < 3; ++c) errors[i][c] = std::abs(srgbLevel(pixels[i].radiance[c]) - srgbLevel(expected[c]));
      }
    });
    for (size_t i = 0; i < pixels.size(); ++i) {
      const Pixel& p = pixels[i];
      for (int c = 0; c < 3; ++c) {
        bands_[{lights_.size(), kMaterials[p.material].kind, bandOf(kRoughness[p.roughness]), p.grazing}].add(
            errors[i][c]);
        spheres_[{lights_.size(), p.material, p.roughness, p.grazing}].add(errors[i][c]);
      }
    }
    lights_.push_back(light);
  }

  const char* causeOf(const ErrorGroup& group) const {
    if (group.light < punctualLights().size()) return "rounding";
    if (group.kind == Dielectric && group.band == 0 && !group.grazing) return "resolution of the environment maps";
    if (group.band == 0) return "mixture of two levels; stretched highlight";
    if (group.band == 1) return "stretched lobe approximated by a round lobe and a cosine lobe";
    return "shape of the lobe; multiple scattering as a cosine lobe";
  }

  Table summary() const {
    Table table{"accuracy", {"light", "material", "roughness", "mean", "facing", "grazing", "max", "cause"}, {}, true};
    for (const auto& [group, facing] : bands_) {
      if (group.grazing) continue;
      ErrorGroup beside = group;
      beside.grazing = true;
      const Errors& grazing = bands_.at(beside);
      table.rows.push_back({lights_[group.light], kKinds[group.kind], kBands[group.band],
                            (facing.sum + grazing.sum) / double(facing.count + grazing.count),
                            facing.sum / double(facing.count), grazing.sum / double(grazing.count),
                            std::max(facing.worst, grazing.worst), causeOf(group)});
    }
    return table;
  }

  Table table() const {
    Table table{"accuracy-spheres", {"light", "material", "roughness", "view", "mean", "max", "samples"}, {}, false};
    for (const auto& [key, errors] : spheres_) {
      const auto& [light, material, roughness, grazing] = key;
      table.rows.push_back({lights_[light], kMaterials[material].name, double{kRoughness[roughness]},
                            grazing ? "grazing" : "facing", errors.sum / double(errors.count), errors.worst,
                            double(errors.count)});
    }
    return table;
  }

  vk::Device device_;
  const uint32_t samples_;
  const std::vector<std::string> files_;
  std::vector<std::string> lights_;
  std::vector<Bounces> bounces_;  // one per pixel's surface
  std::map<ErrorGroup, Errors> bands_;
  std::map<std::tuple<size_t, size_t, size_t, bool>, Errors> spheres_;
};

}  // namespace

Result studyAccuracy(const Options& options) {
  return AccuracyStudy(options).run();
}

}  // namespace latelight::study
