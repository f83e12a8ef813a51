// A glTF file in memory: checked JSON as tinygltf's typed model, and its bytes. Read-only once opened, so that meshes
// and textures can be built from it on all threads at once.
#pragma once

#include <tiny_gltf.h>

#include <atomic>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "base/enclosure.h"
#include "base/memory.h"

namespace latelight::scene::gltf {

using Bytes = std::span<const std::byte>;

struct ImageSource {
  std::string name;  // as in messages: "images[2] (rust.png)"
  Bytes encoded;     // empty where the file could not be read; `problem` says why
  std::string problem;
};

// What loading may allocate or touch, in bytes, so that a small file can't ask for 100 GB or for a day of work: all
// accessors may name the same bytes, and compressed ones may claim any size. Ordinary files stay far below. What any
// file asks for also counts against the machine's memory (base/memory.h).
class Budget {
 public:
  void setInput(size_t inputBytes) { left_ = (size_t{1} << 30) + 256 * inputBytes; }
  // Throws Error(BadInput) naming `what` when the file asks for more than that, Error(DeviceLost) when it exceeds the
  // memory limit.
  void charge(size_t bytes, std::string_view what) const;
  void release() { memory_ = {}; }  // when all is loaded

 private:
  mutable std::atomic<size_t> left_ = 0;
  mutable MemoryClaim memory_;
};

// Attributes with values that are not finite numbers, which exporters write where nothing uses them. They are repaired,
// and reported in one warning. From any thread.
class Repairs {
 public:
  void add(const std::string& attribute) const;  // "meshes[2].primitives[0].TEXCOORD_0"
  void report() const;

 private:
  mutable std::mutex mutex_;
  mutable std::set<std::string> attributes_;
};

struct Document {
  tinygltf::Model model;     // without buffers, images and animations: their bytes never go through tinygltf
  std::vector<Bytes> views;  // of each bufferView, decompressed
  std::vector<ImageSource> images;
  nlohmann::json animations = nlohmann::json::array();  // as in the file, validated
  std::vector<std::filesystem::path> beside;            // files that it names, relative to its folder
  size_t inputBytes = 0;                                // of all files read
  Budget budget;
  Repairs repairs;

  // The memory that `views` and `images` point into.
  std::vector<std::vector<std::byte>> files;
  std::vector<std::unique_ptr<std::byte[]>> decoded;
};

// The JSON chunk and the binary chunk (empty if none) of a .glb, or the text of a .gltf.
struct Container {
  Bytes json;
  Bytes binary;
};
Container readContainer(Bytes file);

// Parsed, validated JSON. Throws Error(BadInput) on anything malformed or on a required extension that is not
// supported.
nlohmann::json readJson(Bytes text);
// The approximate memory of its tree, bytes; text that is not JSON gets some number.
uint64_t treeBytes(Bytes json);

// Fills views and images from the file's buffers: the binary chunk, data URIs, and files within `enclosure`.
void readBuffers(Document& document, const nlohmann::json& root, const Enclosure& enclosure, Bytes binary);

// The files that buffers and images name, relative to the document's folder.
std::vector<std::filesystem::path> filesBeside(const nlohmann::json& root);

// Decompresses bufferViews with EXT_meshopt_compression into document.views.
void decodeMeshopt(Document& document, const nlohmann::json& root, const std::vector<Bytes>& buffers);

// Passes the JSON to tinygltf, patched so that it processes nothing that could fail.
void readModel(Document& document, nlohmann::json root);

void openDocument(Document& document, const std::filesystem::path& path, const Enclosure& enclosure);

// --- extensions
// -------------------------------------------------------------------------------------------------------

// Throws Error(BadInput) naming the first required extension we don't support; warns about used ones that we ignore
// although they change the picture.
void checkExtensions(const nlohmann::json& root);

// The extension's object, or null.
const tinygltf::Value* extension(const tinygltf::ExtensionMap& map, const char* name);
// A number of an extension's object, or the default.
double numberOr(const tinygltf::Value& object, const char* key, double otherwise);
int indexOr(const tinygltf::Value& object, const char* key, int otherwise);

}  // namespace latelight::scene::gltf
