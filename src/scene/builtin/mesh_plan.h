// Meshes as recipes: patches of parametric surface, whose triangles can be counted before any vertex is made.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "scene/builtin/exact_math.h"
#include "scene/scene.h"

namespace latelight::scene::builtin {

// Tessellation scale: 1 is the hall at its default size, and the number of triangles grows with its square.
struct Detail {
  double scale = 1;
  // Segments along a line that has `normal` of them at scale 1.
  uint32_t segments(double normal, uint32_t least = 1) const;
};

// uv in texture tiles. The tangent points along growing uv.x; handedness is the sign of the bitangent as in glTF, where
// the bitangent points along falling uv.y.
struct SurfacePoint {
  dvec3 position{0}, normal{0}, tangent{0};
  dvec2 uv{0};
  double handedness = 1;
};
using Surface = std::function<SurfacePoint(double u, double v)>;

// columns x rows quads over u and v in [0, 1]; its front is on the side of dP/du x dP/dv.
struct Patch {
  uint32_t columns = 1, rows = 1;
  bool closedU = false, closedV = false;  // u (v) = 1 is the same position as 0, but has its own uv
  bool pointV0 = false, pointV1 = false;  // the row at v = 0 (1) is one point
  bool pointU0 = false, pointU1 = false;  // the column at u = 0 (1) is one point
  bool averaged = false;                  // normals are those of the triangles around, for creases finer than the grid
  Surface surface;

  uint64_t triangles() const;
  uint64_t vertices() const { return uint64_t{columns + 1} * (rows + 1); }
};

// A surface from its positions and uv alone: the frame comes from differences inside of [0, 1].
Surface surfaceOf(std::function<dvec3(double, double)> position, std::function<dvec2(double, double)> uv);

// The unoccluded share of light at a point of a surface, [0, 1], in the mesh's own space: baked into vertex colours.
using Shade = std::function<float(vec3 position, vec3 normal)>;

// Unevenness of hewn stone: moves every vertex by one field of space, so that touching patches stay together. The field
// repeats along z, so that copies of a mesh set that far apart meet too.
struct Relief {
  float height = 0;       // metres
  float size = 1;         // metres, of its coarsest bumps
  uint32_t periodZ = 32;  // in units of size
  uint32_t seed = 0;
};

struct MeshPlan {
  std::string name;
  std::vector<Patch> patches;
  Shade shade;    // none: no vertex colours
  Relief relief;  // none where its height is 0

  uint64_t triangles() const;
  void add(Patch patch) { patches.push_back(std::move(patch)); }
  void add(std::vector<Patch> more);
};

// The patches moved by a rigid transform.
std::vector<Patch> transformed(std::vector<Patch> patches, const glm::dmat4& rigid);

// Builds on all threads; bounds are set.
Mesh buildMesh(const MeshPlan& plan);

}  // namespace latelight::scene::builtin
