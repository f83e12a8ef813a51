// Writes the geometry of a scene at rest to OBJ and PLY: all visible instances in the place where they are, in meters.
// OBJ has materials in a library, whose textures are images next to it.
// OBJ has glTF's axes, and PLY has Z up, which are the defaults when such files are loaded.
#include <fmt/format.h>

#include <cmath>
#include <glm/gtc/matrix_inverse.hpp>
#include <iterator>

#include "base/distinct_names.h"
#include "base/error.h"
#include "base/log.h"
#include "export/formats.h"
#include "export/materials.h"
#include "scene/color_slots.h"
#include "shared/color.h"

namespace latelight::exports {
namespace {

using namespace scene;

// An instance's transform and that of its normals, and whether it mirrors.
struct Placement {
  dmat4 transform;
  glm::dmat3 normals;
  bool mirrors;
};

Placement placementOf(const Instance& instance, bool yUp) {
  const dmat4 transform = yUp ? toGltfFromWorld() * instance.toWorld : instance.toWorld;
  const glm::dmat3 linear(transform);
  const double volume = glm::determinant(linear);
  return {transform, volume == 0 ? glm::dmat3(1) : glm::inverseTranspose(linear), volume < 0};
}

vec3 normalIn(const Placement& placement, const vec3& normal) {
  const dvec3 turned = placement.normals * dvec3(normal);
  const double length = glm::length(turned);
  return length > 0 ? vec3(turned / length) : normal;
}

bool isExported(const Instance& instance) {
  return !instance.removed && !instance.hidden;
}

// The names of materials in MTL, where a later material of an equal name would replace the earlier one: those after the
// first get "#2" and so on appended. Removed materials have no name.
std::vector<std::string> materialNames(const Scene& scene) {
  std::vector<std::string> names(scene.materials.size());
  DistinctNames distinct;
  for (size_t i = 0; i < names.size(); ++i) {
    if (scene.materials[i].removed) continue;
    const std::string name = objName(scene.materials[i].name);
    names[i] = distinct.make(name.empty() ? fmt::format("material{}", i) : name);
  }
  return names;
}

}  // namespace

std::string objName(std::string name) {
  for (char& c : name)
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = ' ';
  name.erase(0, name.find_first_not_of(' '));
  name.erase(name.find_last_not_of(' ') + 1);
  if (name.ends_with('\\')) name.back() = '_';
  return name;
}

// --- materials of OBJ -----------------------------------------------------------------------------------------------

namespace {

class MtlWriter {
 public:
  MtlWriter(const Scene& scene, const std::string& stem) : scene_(scene), stem_(stem), names_(materialNames(scene)) {}

  void add(uint32_t index) {
    material_ = &scene_.materials[index];
    const shared::Material& m = material_->data;
    const auto out = std::back_inserter(library_.text);
    fmt::format_to(out, "newmtl {}\nKd {} {} {}\nPr {}\nPm {}\n", names_[index], m.baseColor.r, m.baseColor.g,
                   m.baseColor.b, m.roughness, m.metallic);
    if (m.emissive != vec3(0)) fmt::format_to(out, "Ke {} {} {}\n", m.emissive.r, m.emissive.g, m.emissive.b);
    const bool isTranslucent = (m.flags & (shared::kMaterialBlended | shared::kMaterialMasked)) != 0;
    if ((m.flags & shared::kMaterialBlended) && m.baseColor.a < 1) fmt::format_to(out, "d {}\n", m.baseColor.a);
    if (m.flags & shared::kMaterialUnlit) library_.text += "illum 0\n";
    addMap("map_Kd", shared::kTextureBaseColor);
    if (isTranslucent && hasTransparency()) addMap("map_d -imfchan m", shared::kTextureBaseColor);
    addMap("map_Pr -imfchan g", shared::kTextureMetallicRoughness);
    addMap("map_Pm -imfchan b", shared::kTextureMetallicRoughness);
    addMap(fmt::format("norm -bm {}", m.normalScale), shared::kTextureNormal);
    addMap("map_Ke", shared::kTextureEmissive);
  }

  MaterialLibrary take() { return std::move(library_); }

 private:
  bool isUsed(uint32_t slot) const {
    return material_->slots[slot].texture >= 0 && (material_->data.textures & 1u << slot) != 0;
  }
  bool hasTransparency() const {
    return isUsed(shared::kTextureBaseColor) &&
           hasAlpha(scene_.textures[size_t(material_->slots[shared::kTextureBaseColor].texture)]);
  }

  // MTL repeats a texture in both directions or clamps it in both.
  std::string wrapOption(const Sampler& sampler) const {
    if (sampler.wrapU == Wrap::Clamp && sampler.wrapV == Wrap::Clamp) return " -clamp on";
    if (sampler.wrapU != Wrap::Repeat || sampler.wrapV != Wrap::Repeat)
      warn(
          "the material {} has a texture that is mirrored, or clamped in one direction only, which MTL does not "
          "define: it repeats in the OBJ file",
          material_->name);
    return "";
  }

  // MTL's v points up: glTF's v s + t is 1 - ((1 - v) s + o) with o = 1 - s - t.
  void addMap(const std::string& statement, uint32_t slot) {
    if (!isUsed(slot)) return;
    const shared::TextureTransform& t = material_->data.transforms[slot];
    if (t.uvSet != 0 || t.row0.y != 0 || t.row1.x != 0) {
      warn(
          "the material {} has a texture that is rotated or has other coordinates than the first ones, which MTL does "
          "not define: it is left out",
          material_->name);
      return;
    }
    const TextureSlot& source = material_->slots[slot];
    const auto index = static_cast<uint32_t>(source.texture);
    const bool srgb = isColorSlot(slot), isConverted = srgb != scene_.textures[index].srgb;
    const std::string& name = library_.images[{index, srgb}] = fmt::format("{}_{}{}.png", stem_, index,
                                                                           !isConverted ? ""
                                                                           : srgb       ? "_srgb"
                                                                                        : "_linear");
    std::string options;
    if (t.row0.x != 1 || t.row1.y != 1) options += fmt::format(" -s {} {} 1", t.row0.x, t.row1.y);
    const float down = 1 - t.row1.y - t.row1.z;
    if (t.row0.z != 0 || down != 0) options += fmt::format(" -o {} {} 0", t.row0.z, down);
    options += wrapOption(source.sampler);
    library_.text += fmt::format("{}{} {}\n", statement, options, name);
  }

  const Scene& scene_;
  const std::string& stem_;
  const std::vector<std::string> names_;
  const Material* material_ = nullptr;
  MaterialLibrary library_;
};

}  // namespace

MaterialLibrary encodeMtl(const Scene& scene, const std::string& stem) {
  MtlWriter writer(scene, stem);
  for (uint32_t i = 0; i < scene.materials.size(); ++i)
    if (!scene.materials[i].removed) writer.add(i);
  return writer.take();
}

// --- geometry -------------------------------------------------------------------------------------------------------

std::string encodeObj(const Scene& scene, const std::string& materials) {
  std::string text = fmt::format("mtllib {}\n", materials);
  const auto out = std::back_inserter(text);
  const std::vector<std::string> names = materialNames(scene);
  uint64_t first = 1;
  for (const Instance& instance : scene.instances) {
    if (!isExported(instance)) continue;
    const Mesh& mesh = scene.meshes[instance.mesh];
    const Placement placement = placementOf(instance, true);
    fmt::format_to(out, "o {}\nusemtl {}\n", objName(scene.nodes[instance.node].path.substr(1)),
                   names[instance.material]);
    for (const vec3& position : mesh.positions) {
      const dvec3 p = placement.transform * glm::dvec4(position, 1);
      fmt::format_to(out, "v {} {} {}\n", float(p.x), float(p.y), float(p.z));
    }
    for (const shared::VertexAttributes& a : mesh.attributes) fmt::format_to(out, "vt {} {}\n", a.uv0.x, 1 - a.uv0.y);
    for (const shared::VertexAttributes& a : mesh.attributes) {
      const vec3 n = normalIn(placement, a.normal);
      fmt::format_to(out, "vn {} {} {}\n", n.x, n.y, n.z);
    }
    for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
      const uint64_t a = first + mesh.indices[i], b = first + mesh.indices[i + (placement.mirrors ? 2 : 1)],
                     c = first + mesh.indices[i + (placement.mirrors ? 1 : 2)];
      fmt::format_to(out, "f {0}/{0}/{0} {1}/{1}/{1} {2}/{2}/{2}\n", a, b, c);
    }
    first += mesh.positions.size();
  }
  return text;
}

std::vector<std::byte> encodePly(const Scene& scene) {
  uint64_t vertices = 0, triangles = 0;
  for (const Instance& instance : scene.instances) {
    if (!isExported(instance)) continue;
    vertices += scene.meshes[instance.mesh].positions.size();
    triangles += scene.meshes[instance.mesh].indices.size() / 3;
  }
  if (vertices > INT32_MAX)
    badUsage("the scene has {} vertices, more than a PLY file can index: export .glb", vertices);
  const std::string header = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment meters, Z up\nelement vertex {}\nproperty float x\nproperty float "
      "y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty float u\nproperty float "
      "v\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face {}\nproperty list uchar int "
      "vertex_indices\nend_header\n",
      vertices, triangles);
  std::vector<std::byte> file;
  file.reserve(header.size() + vertices * 35 + triangles * 13);
  const auto append = [&](const void* data, size_t size) {
    const auto* bytes = static_cast<const std::byte*>(data);
    file.insert(file.end(), bytes, bytes + size);
  };
  append(header.data(), header.size());
  for (const Instance& instance : scene.instances) {
    if (!isExported(instance)) continue;
    const Mesh& mesh = scene.meshes[instance.mesh];
    const Placement placement = placementOf(instance, false);
    const vec3 base(scene.materials[instance.material].data.baseColor);
    for (size_t i = 0; i < mesh.positions.size(); ++i) {
      const vec3 p(placement.transform * glm::dvec4(mesh.positions[i], 1));
      const vec3 n = normalIn(placement, mesh.attributes[i].normal);
      const vec2 uv(mesh.attributes[i].uv0.x, 1 - mesh.attributes[i].uv0.y);
      const vec3 color = glm::clamp(base * (mesh.extras.empty() ? vec3(1) : vec3(mesh.extras[i].color)), 0.0f, 1.0f);
      append(&p, sizeof p), append(&n, sizeof n), append(&uv, sizeof uv);
      for (int c = 0; c < 3; ++c) {
        const auto byte = static_cast<uint8_t>(std::lround(shared::srgbFromLinear(color[c]) * 255));
        append(&byte, 1);
      }
    }
  }
  int32_t first = 0;
  for (const Instance& instance : scene.instances) {
    if (!isExported(instance)) continue;
    const Mesh& mesh = scene.meshes[instance.mesh];
    const bool mirrors = placementOf(instance, false).mirrors;
    for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
      const uint8_t three = 3;
      append(&three, 1);
      for (const size_t corner : {i, i + (mirrors ? 2 : 1), i + (mirrors ? 1 : 2)}) {
        const int32_t index = first + static_cast<int32_t>(mesh.indices[corner]);
        append(&index, sizeof index);
      }
    }
    first += static_cast<int32_t>(mesh.positions.size());
  }
  return file;
}

}  // namespace latelight::exports
