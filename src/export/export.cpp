#include "export/export.h"

#include <algorithm>
#include <new>

#include "base/error.h"
#include "base/files.h"
#include "base/log.h"
#include "base/lowercase.h"
#include "base/memory.h"
#include "export/document.h"
#include "export/formats.h"
#include "export/materials.h"
#include "export/nodes.h"
#include "output/used_files.h"

namespace latelight::exports {
namespace {

// An upper bound of what is written, apart from images, whose size is not known before they are encoded.
uint64_t geometryBytes(const scene::Scene& scene) {
  uint64_t bytes = 0;
  for (const scene::Mesh& mesh : scene.meshes) bytes += mesh.bytes();
  return bytes;
}

// OBJ and PLY files without faces cannot be loaded. `extension`: ".obj" or ".ply".
void requireTriangles(const scene::Scene& scene, const std::string& extension) {
  const bool has = std::ranges::any_of(scene.instances, [&](const scene::Instance& instance) {
    return !instance.removed && !instance.hidden && !scene.meshes[instance.mesh].indices.empty();
  });
  if (!has) badUsage("the scene has no visible triangles, and a {} file requires at least one: export .glb", extension);
}

// Writes the scene's .obj file, its .mtl file and the images of that.
void exportObj(const scene::Scene& scene, const std::filesystem::path& file, output::UsedFiles& used) {
  std::string stem = objName(file.stem().string());
  std::ranges::replace(stem, '\\', '_');  // readers take it for a slash
  const std::filesystem::path materials = file.parent_path() / (stem + ".mtl");
  const MaterialLibrary mtl = encodeMtl(scene, stem);
  std::vector<std::filesystem::path> paths{file, materials};
  for (const auto& [use, name] : mtl.images) paths.push_back(file.parent_path() / name);
  used.checkOutputs(paths);
  const std::string obj = encodeObj(scene, materials.filename().string());
  FileGroup files;
  for (const auto& [use, name] : mtl.images)
    files.add(file.parent_path() / name, encodeTexture(scene.textures[use.first], use.second));
  files.add(materials, std::as_bytes(std::span(mtl.text)));
  files.add(file, std::as_bytes(std::span(obj)));
  files.commit();
}

}  // namespace

std::vector<std::byte> encodeGlb(const scene::Scene& scene) {
  const MemoryClaim memory(2 * geometryBytes(scene), "the exported file");
  if (scene.environment) warn("{}: the environment of the file is not exported", scene.source);
  Document document;
  document.root["asset"] = {{"version", "2.0"}, {"generator", "Latelight"}};
  Exported exported{.materials = addMaterials(scene, document)};
  for (const std::string& variant : scene.variants)
    arrayIn(document.extension(document.root, "KHR_materials_variants"), "variants").push_back({{"name", variant}});
  addNodes(scene, document, exported);
  addSkins(scene, document, exported);
  addAnimations(scene, document, exported);
  return document.glb();
}

void checkExportName(const std::filesystem::path& file) {
  const std::string extension = lowercaseExtension(file);
  if (extension != ".glb" && extension != ".obj" && extension != ".ply")
    badUsage("'{}' is not the name of an exported scene: end it in .glb, .obj or .ply", file.string());
}

void exportScene(const scene::Scene& scene, const std::filesystem::path& file,
                 std::span<const std::filesystem::path> inputs) {
  checkExportName(file);
  const std::string extension = lowercaseExtension(file);
  if (extension != ".glb") requireTriangles(scene, extension);
  output::UsedFiles used(inputs);
  try {
    if (extension == ".obj") return exportObj(scene, file, used);
    used.checkOutputs({&file, 1});
    writeFile(file, extension == ".glb" ? encodeGlb(scene) : encodePly(scene));
  } catch (const std::bad_alloc&) {
    failWithoutMemory(fmt::format("the exported file {}", file.string()));
  }
}

}  // namespace latelight::exports
