// Assembles builtin:hall: collects the parts' meshes and instances, and searches for the highest tessellation detail
// within the requested triangle count.
#include "scene/builtin/hall/hall.h"

#include <algorithm>

#include "base/log.h"
#include "base/parallel.h"

namespace latelight::scene::builtin {
namespace hall {
namespace {

// The relief of hewn stone requires triangles finer than its bumps, so it fades in above a detail of 1.5.
Relief reliefAt(const Detail& detail, uint32_t seed) {
  const double t = std::clamp((detail.scale - 1.5) / 2.5, 0.0, 1.0);
  Relief relief;
  relief.height = static_cast<float>(0.0014 * t);
  relief.periodZ = 32;
  relief.size = static_cast<float>(kBay / relief.periodZ);
  relief.seed = seed;
  return relief;
}

bool isHewn(HallMaterial material) {
  return material == HallMaterial::Ashlar || material == HallMaterial::Plaster || material == HallMaterial::Trim;
}

}  // namespace

double tileOf(HallMaterial material) {
  switch (material) {
    case HallMaterial::Ashlar:
      return kAshlarTile;
    case HallMaterial::Mosaic:
      return kMosaicTile;
    case HallMaterial::Tile:
      return kTileTile;
    case HallMaterial::Plaster:
    case HallMaterial::Trim:
      return kPlasterTile;
    default:
      return kMarbleTile;
  }
}

HallBuilder::HallBuilder(Detail detail, uint64_t seed, bool counting, bool glass)
    : detail(detail), seed(static_cast<uint32_t>(seed)), glass(glass), builder("hall"), counting_(counting) {}

uint32_t HallBuilder::mesh(MeshPlan plan) {
  planTriangles_.push_back(plan.triangles());
  plans_.push_back(std::move(plan));
  return static_cast<uint32_t>(plans_.size() - 1);
}

uint32_t HallBuilder::group(const std::string& name, uint32_t parent, const mat4& local) {
  return counting_ ? SceneBuilder::kRoot : builder.addNode(name, parent, local);
}

uint32_t HallBuilder::place(const std::string& name, uint32_t parent, uint32_t mesh, HallMaterial material,
                            const mat4& local) {
  triangles_ += planTriangles_[mesh];
  if (counting_ || planTriangles_[mesh] == 0) return kNoInstance;  // too fine for this detail
  if (isHewn(material)) plans_[mesh].relief = reliefAt(detail, seed);
  builder.addInstance(name, parent, mesh, static_cast<uint32_t>(material), local);
  return static_cast<uint32_t>(builder.scene.instances.size() - 1);
}

void HallBuilder::finish() {
  // Parts too fine for this detail get no mesh either.
  std::vector<uint32_t> renumbered(plans_.size());
  uint32_t kept = 0;
  for (size_t i = 0; i < plans_.size(); ++i) {
    renumbered[i] = kept;
    if (planTriangles_[i] == 0) continue;
    if (kept != i) plans_[kept] = std::move(plans_[i]);
    ++kept;
  }
  plans_.resize(kept);
  for (Instance& instance : builder.scene.instances) instance.mesh = renumbered[instance.mesh];
  builder.scene.meshes.resize(plans_.size());
  Progress progress("Building the hall", plans_.size());
  parallelFor(plans_.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) builder.scene.meshes[i] = buildMesh(plans_[i]), progress.step();
  });
}

mat4 at(double x, double y, double z) {
  mat4 m(1);
  m[3] = vec4(x, y, z, 1);
  return m;
}

mat4 rotatedAt(double x, double y, double z, int quarters) {
  mat4 m = at(x, y, z);
  const float c = float(cosQuarters(quarters)), s = float(sinQuarters(quarters));
  m[0] = vec4(c, 0, -s, 0);
  m[2] = vec4(s, 0, c, 0);
  return m;
}

namespace {

void addParts(HallBuilder& hall, uint64_t spareTriangles) {
  addFloor(hall, spareTriangles);
  addColumns(hall);
  addArcades(hall);
  addGalleries(hall);
  addAisles(hall);
  addVault(hall);
  addEnds(hall);
  addExhibits(hall);
  addLamps(hall);
}

uint64_t trianglesAt(double scale, const HallParameters& p) {
  HallBuilder hall(Detail{scale}, p.seed, true, p.glass);
  addParts(hall, 0);
  return hall.triangles();
}

// Returns the highest detail within the requested triangle count, by bisection; counts grow with detail in steps.
double detailFor(const HallParameters& p) {
  double low = 0.02, high = 1;
  while (trianglesAt(high, p) <= p.triangles) high *= 2;
  for (int i = 0; i < 26; ++i) {
    const double middle = 0.5 * (low + high);
    (trianglesAt(middle, p) <= p.triangles ? low : high) = middle;
  }
  return low;
}

}  // namespace

void addCameras(SceneBuilder& builder) {
  builder.addCamera("main", {-1.5f, 1.65f, 17.4f}, {0.85f, 4.9f, -10}, 1.0f);
  builder.addCamera("vault", {0.6f, 1.5f, 9}, {0.1f, 14.5f, -9}, 1.15f);
  builder.addCamera("gallery", {5.35f, 9.55f, 15.1f}, {-1.6f, 7.6f, -4}, 0.95f);
  builder.addCamera("aisle", {6.35f, 1.6f, 18.6f}, {6.0f, 2.5f, -6}, 0.85f);
  builder.addCamera("apse", {-1.6f, 1.9f, -11}, {0.15f, 4.4f, -21}, 0.95f);
}

}  // namespace hall

Scene makeHall(const HallParameters& p) {
  using namespace hall;
  const Detail detail{detailFor(p)};
  const uint64_t planned = trianglesAt(detail.scale, p);
  HallBuilder hall(detail, p.seed, false, p.glass);
  addParts(hall, p.triangles - std::min(p.triangles, planned));
  hall.finish();
  addMaterials(hall.builder.scene, p);
  addCameras(hall.builder);
  addLights(hall, p.lights);
  return std::move(hall.builder.scene);
}

}  // namespace latelight::scene::builtin
