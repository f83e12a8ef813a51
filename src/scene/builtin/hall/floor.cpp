// The floor, bay by bay: the nave's pattern, a plain band under the arcades, and the aisles' pattern.
#include <fmt/format.h>

#include "scene/builtin/hall/hall.h"
#include "scene/builtin/hall/occlusion.h"
#include "scene/builtin/profile.h"

namespace latelight::scene::builtin::hall {
namespace {

// A level strip of one bay between two x coordinates. All strips have the same number of rows, so that their vertices
// coincide. `uvOf` maps (x, z) to texture tiles.
Patch strip(double x0, double x1, uint32_t columns, uint32_t rows, std::function<dvec2(dvec2)> uvOf) {
  Patch patch;
  patch.columns = columns;
  patch.rows = rows;
  patch.surface = [=, uvOf = std::move(uvOf)](double u, double v) {
    SurfacePoint point;
    point.position = {u >= 1 ? x1 : x0 + (x1 - x0) * u, 0, kBay / 2 - kBay * v};
    point.normal = {0, 1, 0};
    point.tangent = {1, 0, 0};
    point.uv = uvOf({point.position.x, point.position.z});
    return point;
  };
  return patch;
}

}  // namespace

void addFloor(HallBuilder& hall, uint64_t spareTriangles) {
  const Detail& d = hall.detail;
  const uint32_t rows = d.segments(10, 2);
  // Spare triangles, which the other parts' rounding could not use, become extra columns here, because these columns
  // border only columns of the same kind.
  const uint32_t spareColumns = static_cast<uint32_t>(spareTriangles / (uint64_t{2} * rows * kBays));
  const uint32_t columns = d.segments(16, 2) + spareColumns;
  const double tile = kMarbleTile;
  MeshPlan nave{"nave floor", {}, shadeInHall(), {}};
  nave.add(strip(-kFloorX, kFloorX, columns, rows,
                 [](dvec2 p) { return dvec2(p.x / (2 * kFloorX) + 0.5, p.y / kBay + 0.5); }));
  MeshPlan band{"arcade floor", {}, shadeInHall({float(kColumnX), 0, 0}), {}};
  band.add(
      strip(kFloorX - kColumnX, kAisleFloorX - kColumnX, d.segments(5, 2), rows, [tile](dvec2 p) { return p / tile; }));
  MeshPlan aisle{"aisle floor", {}, shadeInHall({float(kAisleX), 0, 0}), {}};
  aisle.add(strip(kAisleFloorX - kAisleX, kOuterX - kAisleX, d.segments(9, 2), rows,
                  [](dvec2 p) { return p / (kBay / 2) + 0.5; }));
  const uint32_t meshes[] = {hall.mesh(std::move(nave)), hall.mesh(std::move(band)), hall.mesh(std::move(aisle))};
  const uint32_t floor = hall.group("floor", SceneBuilder::kRoot);
  for (int bay = kBays - 1; bay >= 0; --bay) {
    const std::string number = std::to_string(kBays - bay);
    const double z = bayCenter(bay);
    hall.place("nave " + number, floor, meshes[0], HallMaterial::NaveFloor, at(0, 0, z));
    for (int side = 0; side < 2; ++side) {
      const double sign = side ? -1 : 1;
      const char* name = side ? "left" : "right";
      hall.place(fmt::format("{} band {}", name, number), floor, meshes[1], HallMaterial::BlackMarble,
                 rotatedAt(sign * kColumnX, 0, z, 2 * side));
      hall.place(fmt::format("{} aisle {}", name, number), floor, meshes[2], HallMaterial::AisleFloor,
                 rotatedAt(sign * kAisleX, 0, z, 2 * side));
    }
  }
}

}  // namespace latelight::scene::builtin::hall
