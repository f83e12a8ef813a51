// Opens a glTF file, and passes its JSON to tinygltf with the modifications that it requires.
#include "scene/gltf/document.h"

#include <limits>
#include <map>
#include <numeric>
#include <string_view>

#include "base/error.h"
#include "base/files.h"
#include "base/log.h"
#include "scene/scene.h"

namespace latelight::scene::gltf {
using nlohmann::json;
namespace {

// tinygltf rejects indices whose accessor has no bufferView, although Draco-compressed and all-zero indices have none.
// They are passed under a private name.
constexpr const char* kIndicesKey = "LATELIGHT_indices";

void hideIndices(json& root) {
  auto meshes = root.find("meshes");
  if (meshes == root.end()) return;
  for (json& mesh : *meshes) {
    for (json& primitive : mesh["primitives"]) {
      auto indices = primitive.find("indices");
      if (indices == primitive.end()) continue;
      int accessor = indices->get<int>();
      if (root["accessors"][size_t(accessor)].contains("bufferView")) continue;
      primitive.erase("indices");
      primitive["extensions"][kIndicesKey] = {{"accessor", accessor}};
    }
  }
}

void restoreIndices(tinygltf::Model& model) {
  for (tinygltf::Mesh& mesh : model.meshes)
    for (tinygltf::Primitive& primitive : mesh.primitives)
      if (const tinygltf::Value* hidden = extension(primitive.extensions, kIndicesKey))
        primitive.indices = indexOr(*hidden, "accessor", -1);
}

// The number of elements of each kind in the JSON.
struct Counts {
  std::map<std::string, size_t> arrays;
  std::vector<size_t> primitives;  // per mesh

  explicit Counts(const json& root) {
    for (const auto& [key, value] : root.items())
      if (value.is_array()) arrays[key] = value.size();
    if (auto meshes = root.find("meshes"); meshes != root.end())
      for (const json& mesh : *meshes) primitives.push_back(mesh["primitives"].size());
  }
  size_t of(const char* key) const {
    auto found = arrays.find(key);
    return found == arrays.end() ? 0 : found->second;
  }
};

// Returns the memory of tinygltf's model, including the name and path of each node, which are stored and indexed.
size_t modelBytes(const Counts& counts) {
  constexpr size_t kNames = 512;
  return counts.of("nodes") * (sizeof(tinygltf::Node) + sizeof(Node) + kNames) +
         counts.of("accessors") * sizeof(tinygltf::Accessor) + counts.of("bufferViews") * sizeof(tinygltf::BufferView) +
         counts.of("materials") * (sizeof(tinygltf::Material) + sizeof(Material)) +
         std::accumulate(counts.primitives.begin(), counts.primitives.end(), size_t{0}) *
             (sizeof(tinygltf::Primitive) + sizeof(Mesh));
}

// tinygltf drops elements that it can't read, which would invalidate checked indices.
template <typename T>
void checkCount(const Counts& counts, const char* key, const std::vector<T>& read) {
  if (counts.of(key) != read.size()) badInput("its {} is invalid", key);
}

void checkModel(const Counts& counts, const tinygltf::Model& model) {
  checkCount(counts, "accessors", model.accessors);
  checkCount(counts, "bufferViews", model.bufferViews);
  checkCount(counts, "cameras", model.cameras);
  checkCount(counts, "materials", model.materials);
  checkCount(counts, "meshes", model.meshes);
  checkCount(counts, "nodes", model.nodes);
  checkCount(counts, "samplers", model.samplers);
  checkCount(counts, "scenes", model.scenes);
  checkCount(counts, "skins", model.skins);
  checkCount(counts, "textures", model.textures);
  for (size_t i = 0; i < model.meshes.size(); ++i)
    if (model.meshes[i].primitives.size() != counts.primitives[i]) badInput("meshes[{}].primitives is invalid", i);
}

}  // namespace

void readModel(Document& document, json root) {
  document.beside = filesBeside(root);
  if (root.contains("animations")) document.animations = root["animations"];
  for (const char* key : {"buffers", "images", "animations", "extras"}) root.erase(key);
  // The bounds of accessors are never read, and exporters write null there for values that are not numbers.
  if (root.contains("accessors"))
    for (json& accessor : root["accessors"])
      for (const char* key : {"min", "max"}) accessor.erase(key);
  hideIndices(root);
  const Counts counts(root);
  document.budget.charge(modelBytes(counts), "its nodes and primitives");
  std::string text = root.dump(-1, ' ', false, json::error_handler_t::replace);
  root = nullptr;  // tinygltf builds its own tree
  if (text.size() > std::numeric_limits<unsigned>::max()) badInput("its JSON is too large");
  tinygltf::TinyGLTF loader;
  std::string error, warning;
  if (!loader.LoadASCIIFromString(&document.model, &error, &warning, text.data(), unsigned(text.size()), ""))
    badInput("it is not valid glTF: {}", std::string_view(error).substr(0, error.find('\n')));
  checkModel(counts, document.model);
  restoreIndices(document.model);
}

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
  json root = readJson(container.json);
  readBuffers(document, root, enclosure, container.binary);
  readModel(document, std::move(root));
}

}  // namespace latelight::scene::gltf
