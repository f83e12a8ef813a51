#include "scene/gltf_document.h"

#include <limits>
#include <string_view>

#include "base/error.h"
#include "base/files.h"

namespace latelight::scene::gltf {
using nlohmann::json;
namespace {

// tinygltf refuses indices whose accessor has no bufferView, though Draco's and all-zero ones have none. They travel
// under a name of our own.
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

// tinygltf drops what it can't read: then indices that were checked no longer fit.
template <typename T>
void checkCount(const json& root, const char* key, const std::vector<T>& read) {
  auto found = root.find(key);
  if ((found == root.end() ? 0 : found->size()) != read.size()) badInput("its {} can't be read", key);
}

void checkModel(const json& root, const tinygltf::Model& model) {
  checkCount(root, "accessors", model.accessors);
  checkCount(root, "bufferViews", model.bufferViews);
  checkCount(root, "cameras", model.cameras);
  checkCount(root, "materials", model.materials);
  checkCount(root, "meshes", model.meshes);
  checkCount(root, "nodes", model.nodes);
  checkCount(root, "samplers", model.samplers);
  checkCount(root, "scenes", model.scenes);
  checkCount(root, "skins", model.skins);
  checkCount(root, "textures", model.textures);
  for (size_t i = 0; i < model.meshes.size(); ++i)
    if (model.meshes[i].primitives.size() != root["meshes"][i]["primitives"].size())
      badInput("meshes[{}].primitives can't be read", i);
}

}  // namespace

void readModel(Document& document, json root) {
  if (root.contains("animations")) document.animations = root["animations"];
  for (const char* key : {"buffers", "images", "animations", "extras"}) root.erase(key);
  hideIndices(root);
  std::string text = root.dump(-1, ' ', false, json::error_handler_t::replace);
  if (text.size() > std::numeric_limits<unsigned>::max()) badInput("its JSON is too large");
  tinygltf::TinyGLTF loader;
  std::string error, warning;
  if (!loader.LoadASCIIFromString(&document.model, &error, &warning, text.data(), unsigned(text.size()), ""))
    badInput("it is not valid glTF: {}", std::string_view(error).substr(0, error.find('\n')));
  checkModel(root, document.model);
  restoreIndices(document.model);
}

void openDocument(Document& document, const std::filesystem::path& path, const Enclosure& enclosure) {
  document.files.push_back(readFile(path));
  document.inputBytes = document.files.back().size();
  Container container = readContainer(document.files.back());
  json root = readJson(container.json);
  readBuffers(document, root, enclosure, container.binary);
  readModel(document, std::move(root));
}

}  // namespace latelight::scene::gltf
