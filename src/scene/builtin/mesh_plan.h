// Meshes as recipes: patches of parametric surfaces, whose triangles can be counted before any vertex is generated.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "scene/exact_math.h"
#include "scene/scene.h"

namespace latelight::scene::builtin {

using namespace exact;
using glm::dvec2;
using glm::dvec3;

// Tessellation scale: 1 is the hall at its default size, and the number of triangles grows with the square of the
// scale.
struct Detail {
  double scale = 1;
  // Returns the number of segments along a line that has `normal` segments at scale 1.
  uint32_t segments(double normal, uint32_t least = 1) const;
};

// uv is in texture tiles. The tangent points along increasing uv.x. The handedness is the sign of the bitangent as in
// glTF, where the bitangent points along decreasing uv.y.
struct SurfacePoint {
  dvec3 position{0}, normal{0}, tangent{0};
  dvec2 uv{0};
  double handedness = 1;
};
using Surface = std::function<SurfacePoint(double u, double v)>;

// A grid of columns x rows quads over u and v in [0, 1]; its front is on the side of dP/du x dP/dv.
struct Patch {
  uint32_t columns = 1, rows = 1;
  bool closedU = false, closedV = false;  // u (v) = 1 has the same position as 0, but its own uv
  bool pointV0 = false, pointV1 = false;  // the row at v = 0 (1) is one point
  bool pointU0 = false, pointU1 = false;  // the column at u = 0 (1) is one point
  bool averaged = false;                  // averages the normals of adjacent triangles, for creases finer than the grid
  Surface surface;

  uint64_t triangles() const;
  uint64_t vertices() const { return uint64_t{columns + 1} * (rows + 1); }
};

// Returns a surface from only its positions and uv: the tangent frame comes from finite differences inside [0, 1].
Surface surfaceOf(std::function<dvec3(double, double)> position, std::function<dvec2(double, double)> uv);

// The unoccluded fraction of light at a point of a surface, in [0, 1], in the mesh's own space. It is baked into vertex
// colors.
using Shade = std::function<float(vec3 position, vec3 normal)>;

// Unevenness of hewn stone, by displacement mapping: one vector field over space moves every vertex, so that adjacent
// patches stay connected. The field repeats along z, so that copies of a mesh at that distance connect too.
struct Relief {
  float height = 0;       // in meters
  float size = 1;         // in meters, of its coarsest bumps
  uint32_t periodZ = 32;  // in units of size
  uint32_t seed = 0;
};

struct MeshPlan {
  std::string name;
  std::vector<Patch> patches;
  Shade shade;    // null: no vertex colors
  Relief relief;  // ignored if its height is 0

  uint64_t triangles() const;
  void add(Patch patch) { patches.push_back(std::move(patch)); }
  void add(std::vector<Patch> more);
};

// Returns the patches moved by a rigid transform.
std::vector<Patch> transformed(std::vector<Patch> patches, const glm::dmat4& rigid);

// Builds the mesh on all threads and sets its bounds.
Mesh buildMesh(const MeshPlan& plan);

}  // namespace latelight::scene::builtin
