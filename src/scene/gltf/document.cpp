// Opens a glTF file: reads its JSON once, and the bytes of its buffers and images.
#include "scene/gltf/document.h"

#include "base/error.h"
#include "base/files.h"
#include "base/log.h"
#include "scene/gltf/json.h"
#include "scene/scene.h"

namespace latelight::scene::gltf {
using nlohmann::json;
namespace {

// Returns the memory of the model, and of the scene's elements that are created from it, including the name and path of
// each node, which are stored and indexed.
size_t modelBytes(const json& root) {
  constexpr size_t kNames = 512;
  const auto count = [&](const char* key) { return arrayIn(root, key).size(); };
  size_t primitives = 0;
  for (const json& mesh : arrayIn(root, "meshes")) primitives += mesh["primitives"].size();
  return count("nodes") * (sizeof(file::Node) + sizeof(Node) + kNames) + count("accessors") * sizeof(file::Accessor) +
         count("bufferViews") * sizeof(BufferView) + count("materials") * (sizeof(file::Material) + sizeof(Material)) +
         primitives * (sizeof(file::Primitive) + sizeof(Mesh));
}

}  // namespace

void Repairs::add(const std::string& attribute) const {
  const std::lock_guard lock(mutex_);
  attributes_.insert(attribute);
}

void Repairs::report() const {
  const std::lock_guard lock(mutex_);
  if (attributes_.empty()) return;
  const size_t others = attributes_.size() - 1;
  const std::string more = others == 0 ? "" : fmt::format(" and {} other attribute{}", others, others == 1 ? "" : "s");
  warn(
      "{}{} of the file {} values that are not finite numbers: colors become 1, normals are computed, triangles "
      "without positions are left out, and all else becomes 0",
      *attributes_.begin(), more, others == 0 ? "has" : "have");
}

void openDocument(Document& document, const std::filesystem::path& path, const AllowedFolders& enclosure) {
  document.files.push_back(readFile(path));
  document.inputBytes = document.files.back().size();
  Container container = readContainer(document.files.back());
  const MemoryClaim tree(treeBytes(container.json), "its JSON");
  const JsonTree read = readJson(container.json);
  const json& root = *read;
  readBuffers(document, root, enclosure, container.binary);
  document.beside = externalFiles(root);
  document.budget.charge(modelBytes(root), "its nodes and primitives");
  document.model = file::readModel(root);
}

}  // namespace latelight::scene::gltf
