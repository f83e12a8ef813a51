// Tessellates patches of parametric surfaces into meshes: vertices, normals, indices, relief and baked occlusion, in
// parallel over rows of patches.
#include "scene/builtin/mesh_plan.h"

#include <algorithm>

#include "base/parallel.h"
#include "scene/builtin/random.h"
#include "scene/scene_builder.h"

namespace latelight::scene::builtin {
namespace {

// Finite difference step in [0, 1]: small relative to any curvature here, large relative to rounding.
constexpr double kStep = 1e-5;

dvec3 unitOr(dvec3 v, dvec3 otherwise) {
  const double length = glm::length(v);
  return length > 1e-300 ? v / length : otherwise;
}

// Returns a unit vector perpendicular to n that depends only on n.
dvec3 across(dvec3 n) {
  return glm::normalize(std::abs(n.y) < 0.9 ? glm::cross(dvec3(0, 1, 0), n) : glm::cross(dvec3(1, 0, 0), n));
}

struct Displaced {
  vec3 position, normal;
};

// Displaces a point to p + D(p) and transforms its normal by the displacement's Jacobian: n' ~ n - (grad D)^T n to
// first order, because D's slopes are small.
Displaced displace(const Relief& relief, vec3 p, vec3 n) {
  const auto field = [&](vec3 at) {
    vec3 d(0);
    float weight = relief.height, scale = 1 / relief.size;
    uint32_t period = relief.periodZ;
    for (uint32_t octave = 0; octave < 3; ++octave, weight *= 0.5f, scale *= 2, period *= 2) {
      const uint32_t seed = relief.seed * 7919u + octave * 131u;
      for (int axis = 0; axis < 3; ++axis) d[axis] += weight * noise3(at * scale, period, seed + uint32_t(axis));
    }
    return d;
  };
  const vec3 here = field(p);
  const float h = relief.size * 0.02f;
  vec3 gradient(0);  // gradient of dot(D, n)
  for (int axis = 0; axis < 3; ++axis) {
    vec3 q = p;
    q[axis] += h;
    gradient[axis] = glm::dot(field(q) - here, n) / h;
  }
  const vec3 slope = gradient - n * glm::dot(gradient, n);
  return {p + here, glm::normalize(n - slope)};
}

// The offsets of a patch's vertices and indices in the mesh.
struct PatchOffsets {
  const Patch* patch;
  size_t vertex, index;
};

class MeshBuild {
 public:
  MeshBuild(const MeshPlan& plan, Mesh& mesh) : plan_(plan), mesh_(mesh) {}

  void vertexRow(const PatchOffsets& offsets, uint32_t j) {
    const Patch& patch = *offsets.patch;
    for (uint32_t i = 0; i <= patch.columns; ++i) {
      const double u = double(i) / patch.columns, v = double(j) / patch.rows;
      const bool wrapU = patch.closedU && i == patch.columns, wrapV = patch.closedV && j == patch.rows;
      SurfacePoint point = patch.surface(wrapU ? 0 : u, wrapV ? 0 : v);
      if (wrapU || wrapV) point.uv = patch.surface(u, v).uv;
      store(offsets.vertex + size_t{j} * (patch.columns + 1) + i, point);
    }
  }

  // Computes the averaged normals of a row of a patch whose positions are all set.
  void averageRow(const PatchOffsets& offsets, uint32_t j) {
    const Patch& patch = *offsets.patch;
    const bool point = (patch.pointV0 && j == 0) || (patch.pointV1 && j == patch.rows);
    vec3 all(0);
    for (uint32_t i = 0; point && i < patch.columns; ++i) all += normalAround(offsets, i, j);
    for (uint32_t i = 0; i <= patch.columns; ++i) {
      const vec3 sum = point ? all : normalAround(offsets, i, j);
      const float length = glm::length(sum);
      if (!(length > 0)) continue;
      shared::VertexAttributes& a = mesh_.attributes[offsets.vertex + size_t{j} * (patch.columns + 1) + i];
      a.normal = sum / length;
      const vec3 tangent = vec3(a.tangent) - a.normal * glm::dot(a.normal, vec3(a.tangent));
      const dvec3 unit = unitOr(dvec3(tangent), across(dvec3(a.normal)));
      a.tangent = vec4(vec3(unit), a.tangent.w);
    }
  }

  // Writes two triangles per quad, split along its shorter diagonal, and skips degenerate triangles.
  void indexRow(const PatchOffsets& offsets, uint32_t j, size_t at) {
    const Patch& patch = *offsets.patch;
    const bool first = patch.pointV0 && j == 0, last = patch.pointV1 && j + 1 == patch.rows;
    uint32_t* out = mesh_.indices.data() + at;
    for (uint32_t i = 0; i < patch.columns; ++i) {
      const uint32_t a = uint32_t(offsets.vertex + size_t{j} * (patch.columns + 1) + i), b = a + 1;
      const uint32_t d = a + patch.columns + 1, c = d + 1;
      const auto triangle = [&](uint32_t x, uint32_t y, uint32_t z) {
        *out++ = x;
        *out++ = y;
        *out++ = z;
      };
      if (first || (patch.pointU1 && i + 1 == patch.columns)) {
        triangle(a, c, d);
        if (!first) continue;
      } else if (last || (patch.pointU0 && i == 0)) {
        triangle(a, b, c);
      } else if (shorter(a, c, b, d)) {
        triangle(a, b, c);
        triangle(a, c, d);
      } else {
        triangle(a, b, d);
        triangle(b, c, d);
      }
    }
  }

 private:
  bool shorter(uint32_t a, uint32_t c, uint32_t b, uint32_t d) const {
    const vec3 ac = mesh_.positions[c] - mesh_.positions[a], bd = mesh_.positions[d] - mesh_.positions[b];
    return glm::dot(ac, ac) <= glm::dot(bd, bd);
  }

  // Returns the sum of the area vectors of the four quads around a vertex, across the seam if the patch is closed.
  vec3 normalAround(const PatchOffsets& offsets, uint32_t i, uint32_t j) const {
    const Patch& patch = *offsets.patch;
    const auto at = [&](uint32_t column, uint32_t row) {
      return mesh_.positions[offsets.vertex + size_t{row} * (patch.columns + 1) + column];
    };
    const auto quadArea = [&](int64_t column, int64_t row) {
      if (patch.closedU) column = (column + patch.columns) % patch.columns;
      if (patch.closedV) row = (row + patch.rows) % patch.rows;
      if (column < 0 || row < 0 || column >= patch.columns || row >= patch.rows) return vec3(0);
      const uint32_t c = uint32_t(column), r = uint32_t(row);
      return glm::cross(at(c + 1, r + 1) - at(c, r), at(c, r + 1) - at(c + 1, r));
    };
    const int64_t c = i, r = j;
    return quadArea(c - 1, r - 1) + quadArea(c, r - 1) + quadArea(c - 1, r) + quadArea(c, r);
  }

  void store(size_t at, const SurfacePoint& point) {
    vec3 position(point.position), normal(point.normal);
    if (plan_.relief.height > 0) {
      const Displaced displaced = displace(plan_.relief, position, normal);
      position = displaced.position;
      normal = displaced.normal;
    }
    const dvec3 n(normal);
    const vec3 tangent(unitOr(point.tangent - n * glm::dot(n, point.tangent), across(n)));
    mesh_.positions[at] = position;
    mesh_.attributes[at] = {normal, vec4(tangent, point.handedness), vec2(point.uv)};
    if (!plan_.shade) return;
    // The surroundings light occluded surfaces by reflection, so the shadow is warmer than the light.
    const float dark = 1 - plan_.shade(position, normal);
    mesh_.extras[at] = {vec2(point.uv), vec4(1 - 0.9f * dark, 1 - 0.96f * dark, 1 - dark, 1)};
  }

  const MeshPlan& plan_;
  Mesh& mesh_;
};

uint64_t trianglesOfRow(const Patch& patch, uint32_t j) {
  if ((patch.pointV0 && j == 0) || (patch.pointV1 && j + 1 == patch.rows)) return patch.columns;
  return uint64_t{2} * patch.columns - patch.pointU0 - patch.pointU1;
}

}  // namespace

uint32_t Detail::segments(double normal, uint32_t least) const {
  return std::max(least, static_cast<uint32_t>(std::floor(normal * scale + 0.5)));
}

uint64_t Patch::triangles() const {
  uint64_t count = 0;
  if (rows < 4) {
    for (uint32_t j = 0; j < rows; ++j) count += trianglesOfRow(*this, j);
    return count;
  }
  return trianglesOfRow(*this, 0) + trianglesOfRow(*this, rows - 1) + (rows - 2) * trianglesOfRow(*this, 1);
}

uint64_t MeshPlan::triangles() const {
  uint64_t count = 0;
  for (const Patch& patch : patches) count += patch.triangles();
  return count;
}

void MeshPlan::add(std::vector<Patch> more) {
  for (Patch& patch : more) patches.push_back(std::move(patch));
}

Surface surfaceOf(std::function<dvec3(double, double)> position, std::function<dvec2(double, double)> uv) {
  return [position = std::move(position), uv = std::move(uv)](double u, double v) {
    SurfacePoint point;
    point.position = position(u, v);
    point.uv = uv(u, v);
    // Clamp to slightly inside, so that rows and columns that are a single point have a frame too.
    u = std::clamp(u, 2 * kStep, 1 - 2 * kStep);
    v = std::clamp(v, 2 * kStep, 1 - 2 * kStep);
    const double u0 = u - kStep, u1 = u + kStep, v0 = v - kStep, v1 = v + kStep;
    const dvec3 du = position(u1, v) - position(u0, v), dv = position(u, v1) - position(u, v0);
    point.normal = unitOr(glm::cross(du / (u1 - u0), dv / (v1 - v0)), dvec3(0, 1, 0));
    const dvec2 uvu = (uv(u1, v) - uv(u0, v)), uvv = (uv(u, v1) - uv(u, v0));
    const double determinant = uvu.x * uvv.y - uvu.y * uvv.x;
    const dvec3 tangent = (du * uvv.y - dv * uvu.y) * (determinant < 0 ? -1.0 : 1.0);
    point.tangent = unitOr(tangent, across(point.normal));
    // A uv mapping that preserves the image's orientation on the surface has a negative determinant, because v points
    // down.
    point.handedness = determinant < 0 ? 1 : -1;
    return point;
  };
}

std::vector<Patch> transformed(std::vector<Patch> patches, const glm::dmat4& rigid) {
  for (Patch& patch : patches) {
    patch.surface = [surface = std::move(patch.surface), rigid](double u, double v) {
      SurfacePoint point = surface(u, v);
      point.position = dvec3(rigid * glm::dvec4(point.position, 1));
      point.normal = glm::dmat3(rigid) * point.normal;
      point.tangent = glm::dmat3(rigid) * point.tangent;
      return point;
    };
  }
  return patches;
}

Mesh buildMesh(const MeshPlan& plan) {
  Mesh mesh;
  mesh.name = plan.name;
  struct Row {
    PatchOffsets offsets;
    uint32_t j;
    size_t index;
  };
  std::vector<Row> rows;
  size_t vertices = 0, indices = 0;
  for (const Patch& patch : plan.patches) {
    const PatchOffsets offsets{&patch, vertices, indices};
    for (uint32_t j = 0; j <= patch.rows; ++j) {
      rows.push_back({offsets, j, indices});
      if (j < patch.rows) indices += 3 * trianglesOfRow(patch, j);
    }
    vertices += patch.vertices();
  }
  mesh.positions.resize(vertices);
  mesh.attributes.resize(vertices);
  if (plan.shade) mesh.extras.resize(vertices);
  mesh.indices.resize(indices);
  MeshBuild build(plan, mesh);
  const size_t grain = std::max<size_t>(1, 4096 * rows.size() / std::max<size_t>(1, vertices));
  parallelFor(rows.size(), grain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) build.vertexRow(rows[i].offsets, rows[i].j);
  });
  parallelFor(rows.size(), grain * 4, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      if (rows[i].offsets.patch->averaged) build.averageRow(rows[i].offsets, rows[i].j);
  });
  parallelFor(rows.size(), grain * 4, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      if (rows[i].j < rows[i].offsets.patch->rows) build.indexRow(rows[i].offsets, rows[i].j, rows[i].index);
  });
  findBounds(mesh);
  return mesh;
}

}  // namespace latelight::scene::builtin
