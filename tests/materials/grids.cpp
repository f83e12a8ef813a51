#include "materials/grids.h"

#include <cmath>

#include "models/parts.h"

namespace latelight::materials {

using glm::vec3;
using glm::vec4;
using models::json;

namespace {

// Position on a sphere by column and row, from 0 to 1.
template <typename Set>
Grid grid(const char* name, bool environment, Set set) {
  Grid g{name, {}, environment};
  for (uint32_t row = 0; row < kRows; ++row)
    for (uint32_t column = 0; column < kColumns; ++column) {
      Sphere& s = g.spheres.emplace_back();
      set(s, s.layers, float(column) / float(kColumns - 1), row);
    }
  return g;
}

using Layers = shared::SurfaceLayers;

Grid clearcoat() {
  return grid("clearcoat", true, [](Sphere& s, Layers& l, float x, uint32_t row) {
    s.baseColor = vec4(0.7f, 0.1f, 0.1f, 1.0f);
    s.metallic = row == 2 ? 1.0f : 0.0f;
    l.clearcoat = row == 0 ? 0.5f : 1.0f;
    l.clearcoatRoughness = 0.1f + 0.9f * x;
  });
}
Grid sheen() {
  const vec3 colors[] = {{0.9f, 0.9f, 0.9f}, {0.9f, 0.2f, 0.3f}, {0.2f, 0.5f, 0.9f}};
  const vec4 bases[] = {{0.02f, 0.02f, 0.02f, 1.0f}, {0.1f, 0.2f, 0.5f, 1.0f}, {0.8f, 0.8f, 0.8f, 1.0f}};
  return grid("sheen", true, [&](Sphere& s, Layers& l, float x, uint32_t row) {
    s.baseColor = bases[row];
    s.roughness = 0.8f;
    l.sheenColor = colors[row];
    l.sheenRoughness = 0.2f + 0.8f * x;
  });
}
Grid anisotropy() {
  return grid("anisotropy", true, [](Sphere& s, Layers& l, float x, uint32_t row) {
    s.baseColor = vec4(0.9f, 0.7f, 0.4f, 1.0f);
    s.metallic = 1.0f;
    s.roughness = 0.2f + 0.2f * float(row);
    l.anisotropy = x;
  });
}
Grid iridescence() {
  return grid("iridescence", true, [](Sphere& s, Layers& l, float x, uint32_t row) {
    s.baseColor = row == 1 ? vec4(0.5f, 0.5f, 0.5f, 1.0f) : vec4(0.05f, 0.05f, 0.05f, 1.0f);
    s.metallic = row == 1 ? 1.0f : 0.0f;
    s.roughness = row == 2 ? 0.6f : 0.2f;
    l.iridescence = 1.0f;
    l.iridescenceIor = 1.3f + 0.4f * float(row);
    l.iridescenceThickness = 150.0f + 650.0f * x;
  });
}
Grid transmission() {
  return grid("transmission", false, [](Sphere& s, Layers& l, float x, uint32_t row) {
    s.baseColor = row == 1 ? vec4(0.3f, 0.8f, 0.4f, 1.0f) : vec4(0.9f, 0.9f, 0.9f, 1.0f);
    s.roughness = 0.2f + 0.8f * x;
    l.transmission = row == 0 ? 0.5f : 1.0f;
    l.ior = row == 2 ? 1.25f : 1.5f;
  });
}
Grid volume() {
  return grid("volume", false, [](Sphere& s, Layers& l, float x, uint32_t row) {
    s.baseColor = vec4(1.0f);
    s.roughness = 0.4f;
    s.attenuationColor = vec3(0.9f, 0.5f, 0.2f);
    s.attenuationDistance = 2.0f - 1.8f * x;
    l.transmission = 1.0f;
    l.thickness = 0.6f;
    l.ior = 1.2f + 0.3f * float(row);
  });
}
Grid dispersion() {
  return grid("dispersion", false, [](Sphere& s, Layers& l, float x, uint32_t row) {
    s.baseColor = vec4(1.0f);
    s.roughness = 0.2f + 0.1f * float(row);
    l.transmission = 1.0f;
    l.thickness = 0.6f;
    l.ior = 1.7f;
    l.dispersion = 5.0f * x;
  });
}
Grid diffuseTransmission() {
  return grid("diffuse transmission", true, [](Sphere& s, Layers& l, float x, uint32_t row) {
    s.baseColor = vec4(0.3f, 0.6f, 0.2f, 1.0f);
    l.diffuseTransmission = x;
    l.diffuseTransmissionColor = row == 1 ? vec3(0.9f, 0.3f, 0.2f) : vec3(0.9f, 0.9f, 0.5f);
    l.clearcoat = row == 2 ? 1.0f : 0.0f;
    l.clearcoatRoughness = 0.2f;
  });
}
Grid mixture() {
  return grid("mixture", true, [](Sphere& s, Layers& l, float x, uint32_t row) {
    s.baseColor = vec4(0.7f, 0.5f, 0.3f, 1.0f);
    s.metallic = 0.5f * float(row);
    s.roughness = 0.3f + 0.2f * x;
    l.clearcoat = 0.6f, l.clearcoatRoughness = 0.15f;
    l.sheenColor = vec3(0.4f, 0.4f, 0.6f), l.sheenRoughness = 0.5f;
    l.anisotropy = 0.8f * x;
    l.iridescence = 0.7f, l.iridescenceThickness = 450.0f;
    l.diffuseTransmission = 0.4f;
  });
}

json extensionsOf(const Sphere& s) {
  const Layers& l = s.layers;
  const auto list = [](vec3 v) { return json{v.x, v.y, v.z}; };
  json e = json::object();
  if (l.clearcoat > 0.0f)
    e["KHR_materials_clearcoat"] = {{"clearcoatFactor", l.clearcoat},
                                    {"clearcoatRoughnessFactor", l.clearcoatRoughness}};
  if (l.sheenColor != vec3(0.0f))
    e["KHR_materials_sheen"] = {{"sheenColorFactor", list(l.sheenColor)}, {"sheenRoughnessFactor", l.sheenRoughness}};
  if (l.anisotropy > 0.0f) e["KHR_materials_anisotropy"] = {{"anisotropyStrength", l.anisotropy}};
  if (l.iridescence > 0.0f)
    e["KHR_materials_iridescence"] = {{"iridescenceFactor", l.iridescence},
                                      {"iridescenceIor", l.iridescenceIor},
                                      {"iridescenceThicknessMaximum", l.iridescenceThickness}};
  if (l.transmission > 0.0f) e["KHR_materials_transmission"] = {{"transmissionFactor", l.transmission}};
  if (l.ior != 1.5f) e["KHR_materials_ior"] = {{"ior", l.ior}};
  if (l.thickness > 0.0f) e["KHR_materials_volume"] = {{"thicknessFactor", l.thickness}};
  if (s.attenuationDistance > 0.0f) {
    e["KHR_materials_volume"]["attenuationColor"] = list(s.attenuationColor);
    e["KHR_materials_volume"]["attenuationDistance"] = s.attenuationDistance;
  }
  if (l.dispersion > 0.0f) e["KHR_materials_dispersion"] = {{"dispersion", l.dispersion}};
  if (l.diffuseTransmission > 0.0f)
    e["KHR_materials_diffuse_transmission"] = {{"diffuseTransmissionFactor", l.diffuseTransmission},
                                               {"diffuseTransmissionColorFactor", list(l.diffuseTransmissionColor)}};
  return e;
}

// A sphere's tangent points around the axis, towards increasing u; in the frame of `normal`.
vec3 tangentAt(vec3 normal, vec3 axis) {
  const vec3 along = glm::cross(axis, normal);
  return glm::length(along) > 1e-4f ? glm::normalize(along) : vec3(1.0f, 0.0f, 0.0f);
}

// The center of a sphere's square: x to the right, y up.
glm::vec2 center(uint32_t column, uint32_t row) {
  return {float(column) + 0.5f - 0.5f * float(kColumns), 0.5f * float(kRows) - 0.5f - float(row)};
}

}  // namespace

const std::vector<Grid>& grids() {
  static const std::vector<Grid> all{clearcoat(), sheen(),      anisotropy(),          iridescence(), transmission(),
                                     volume(),    dispersion(), diffuseTransmission(), mixture()};
  return all;
}

std::vector<std::byte> glb(const Grid& grid) {
  models::GltfBuilder file;
  models::Shape ball = models::sphere(96, 64);
  std::vector<vec4> tangents;
  for (const vec3& n : ball.normals) tangents.emplace_back(tangentAt(n, vec3(0.0f, 1.0f, 0.0f)), 1.0f);
  for (vec3& p : ball.positions) p *= kRadius;
  for (const char* name : {"clearcoat", "sheen", "anisotropy", "iridescence", "transmission", "volume", "dispersion",
                           "diffuse_transmission", "ior"})
    file.use((std::string("KHR_materials_") + name).c_str());
  json primitive = models::primitive(file, ball, 0);
  primitive["attributes"]["TANGENT"] = file.vectors(tangents);
  for (uint32_t i = 0; i < grid.spheres.size(); ++i) {
    const Sphere& s = grid.spheres[i];
    const int material = models::plain(file, grid.name.c_str(), vec3(s.baseColor), s.metallic, s.roughness);
    if (const json extensions = extensionsOf(s); !extensions.empty())
      file.root["materials"][material]["extensions"] = extensions;
    primitive["material"] = material;
    const int mesh = file.add("meshes", {{"primitives", json::array({primitive})}});
    const glm::vec2 place = center(i % kColumns, i / kColumns);
    models::place(file, "sphere " + std::to_string(i), mesh, vec3(place, 0.0f));
  }
  const json view{{"xmag", 0.5f * float(kColumns)}, {"ymag", 0.5f * float(kRows)}, {"znear", 0.1}, {"zfar", 10}};
  const int camera = file.add("cameras", {{"type", "orthographic"}, {"orthographic", view}});
  file.node({{"camera", camera}, {"translation", {0, 0, 4}}});
  return file.glb();
}

bool pointAt(const Grid& grid, uint32_t x, uint32_t y, shared::Surface& s, shared::SurfaceLayers& layers) {
  const uint32_t column = x / kCell, row = y / kCell;
  const auto inSquare = [](uint32_t pixel) { return (float(pixel % kCell) + 0.5f) / float(kCell) - 0.5f; };
  const float right = inSquare(x) / kRadius, up = -inSquare(y) / kRadius;
  const float rest = 1.0f - right * right - up * up;
  if (rest < 0.1f * 0.1f) return false;
  const Sphere& sphere = grid.spheres[row * kColumns + column];
  s = shared::emptySurface();
  s.normal = s.geonormal = vec3(right, -std::sqrt(rest), up);
  const glm::vec2 place = center(column, row);
  s.position = vec3(place.x, 0.0f, place.y) + s.normal * kRadius;
  s.baseColor = vec3(sphere.baseColor), s.metallic = sphere.metallic, s.roughness = sphere.roughness;
  const float root = (sphere.layers.ior - 1.0f) / (sphere.layers.ior + 1.0f);
  s.f0 = vec3(root * root), s.f90 = 1.0f;
  layers = sphere.layers;
  layers.clearcoatNormal = s.normal;
  layers.anisotropyDirection = tangentAt(s.normal, vec3(0.0f, 0.0f, 1.0f));
  layers.absorption = shared::absorptionOf(sphere.attenuationColor, sphere.attenuationDistance);
  return true;
}

std::vector<scene::Light> lights() {
  scene::Light key;
  key.type = shared::kLightDirectional;
  key.direction = glm::normalize(vec3(0.5f, 0.8f, -0.6f));
  key.intensity = 2.0f;
  scene::Light point;
  point.type = shared::kLightPoint;
  point.position = vec3(-4.0f, -4.0f, -1.0f);
  point.intensity = 25.0f, point.color = vec3(0.7f, 0.8f, 1.0f);
  scene::Light behind = key;
  behind.direction = glm::normalize(vec3(-0.2f, -1.0f, -0.3f));
  behind.color = vec3(1.0f, 0.8f, 0.6f);
  return {key, point, behind};
}

}  // namespace latelight::materials
