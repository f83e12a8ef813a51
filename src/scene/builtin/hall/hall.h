// The builder of builtin:hall and the parts from which it is assembled. Each part adds its meshes and places instances.
#pragma once

#include <string>
#include <vector>

#include "scene/builtin/hall/dimensions.h"
#include "scene/builtin/make.h"
#include "scene/builtin/mesh_plan.h"
#include "scene/scene_builder.h"

namespace latelight::scene::builtin::hall {

// Surface materials of the hall: indices into the scene's materials.
enum class HallMaterial : uint32_t {
  NaveFloor,
  AisleFloor,
  Ashlar,
  Plaster,
  Trim,    // pale stone moldings
  Marble,  // white, veined
  RedMarble,
  GreenMarble,
  BlackMarble,
  VaultBlue,  // painted plaster
  Mosaic,     // gold
  Tile,       // glazed
  Gilt,
  Brass,
  Bronze,
  Copper,
  Steel,
  Ceramic,
  Celadon,
  Obsidian,
  LampGlass,  // lit lamp
  DarkGlass,  // unlit lamp
  WindowGlass,
  CaseGlass,  // alpha blended, as all that follow: only in a hall with glass
  AmberGlass,
  BlueGlass,
  GreenGlass,
  Count
};

// Side lengths of the texture tiles, in meters.
inline constexpr double kAshlarTile = 2.25, kPlasterTile = 3.0, kMarbleTile = 1.5, kMosaicTile = 1.0, kTileTile = 0.9;
double tileOf(HallMaterial material);

// A possible light position: one of the hall's own lamps.
struct LampSite {
  vec3 position;
  vec3 color;
  float weight;       // relative intensity
  float range;        // in meters, when all sites are lit
  uint32_t instance;  // its material shows whether the lamp is lit; kNoInstance if it has no visible glass
};
inline constexpr uint32_t kNoInstance = ~0u;

// Collects the hall's meshes, or only counts their triangles if `counting`.
class HallBuilder {
 public:
  HallBuilder(Detail detail, uint64_t seed, bool counting, bool glass = false);

  const Detail detail;
  const uint32_t seed;
  const bool glass;

  uint32_t mesh(MeshPlan plan);
  uint32_t group(const std::string& name, uint32_t parent, const mat4& local = mat4(1));
  // Returns the instance's index in the scene.
  uint32_t place(const std::string& name, uint32_t parent, uint32_t mesh, HallMaterial material,
                 const mat4& local = mat4(1));
  void lamp(const LampSite& site) { lamps.push_back(site); }

  uint64_t triangles() const { return triangles_; }
  bool counting() const { return counting_; }
  // Builds the planned meshes into the scene.
  void finish();

  SceneBuilder builder;
  std::vector<LampSite> lamps;

 private:
  const bool counting_;
  uint64_t triangles_ = 0;
  std::vector<MeshPlan> plans_;
  std::vector<uint64_t> planTriangles_;
};

mat4 at(double x, double y, double z);
mat4 rotatedAt(double x, double y, double z, int quarters);  // about +Y, exact

// Bays are numbered from the apse, and bay boundaries from 0 to kBays.
inline double bayCenter(int bay) {
  return (bay + 0.5) * kBay - kHalfLength;
}
inline double bayBoundary(int boundary) {
  return boundary * kBay - kHalfLength;
}

// The center of a bay of the arcade at +X.
inline const vec3 kBayOnTheRight(float(kColumnX), 0, 0);

// The parts, one per file.
void addColumns(HallBuilder& hall);
void addArcades(HallBuilder& hall);
void addGalleries(HallBuilder& hall);
void addAisles(HallBuilder& hall);
void addVault(HallBuilder& hall);
void addEnds(HallBuilder& hall);
void addFloor(HallBuilder& hall, uint64_t spareTriangles);
void addExhibits(HallBuilder& hall);
void addLamps(HallBuilder& hall);

// Fills scene.textures and scene.materials in the order of Stuff: all of them with glass, otherwise only the unblended
// ones.
void addMaterials(Scene& scene, const HallParameters& p);

// Adds the cameras; the one named "main" comes first.
void addCameras(SceneBuilder& builder);

// Adds exactly `count` point lights: the lamps' sites first, then small ones over all surfaces. Their intensities are
// scaled to expose the view of the scene's first camera.
void addLights(HallBuilder& hall, uint32_t count);

}  // namespace latelight::scene::builtin::hall
