// A glTF file in memory: the contents of its JSON, and its bytes. It is read-only once opened, so that meshes and
// textures can be built from it on all threads at once.
#pragma once

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

#include "base/allowed_folders.h"
#include "base/json_tree.h"
#include "base/memory.h"
#include "scene/gltf/model.h"

namespace latelight::scene::gltf {

using Bytes = std::span<const std::byte>;

struct ImageSource {
  std::string name;  // as in messages: "images[2] (rust.png)"
  Bytes encoded;     // empty if the file could not be read; `problem` states why
  std::string problem;
};

// Limits the bytes that loading may allocate or read, so that a small file can't request 100 GB or a day of work: all
// accessors may refer to the same bytes, and compressed data may claim any size. Ordinary files stay far below the
// limit. Requested bytes also count against the machine's memory (base/memory.h).
class Budget {
 public:
  void setInput(size_t inputBytes) { left_ = (size_t{1} << 30) + 256 * inputBytes; }
  // Throws Error(BadInput) that names `what` if the file exceeds this budget, and Error(OutOfMemory) if it exceeds the
  // memory limit.
  void charge(size_t bytes, std::string_view what) const;
  void release() { memory_ = {}; }  // call after loading is complete

 private:
  mutable std::atomic<size_t> left_ = 0;
  mutable MemoryClaim memory_;
};

// Attributes with values that are not finite numbers, which exporters write for unused attributes. They are repaired
// and reported in one warning. Thread-safe.
class Repairs {
 public:
  void add(const std::string& attribute) const;  // "meshes[2].primitives[0].TEXCOORD_0"
  void report() const;

 private:
  mutable std::mutex mutex_;
  mutable std::set<std::string> attributes_;
};

struct BufferView {
  Bytes bytes;            // decompressed
  size_t byteStride = 0;  // 0: elements are tightly packed
};

struct Document {
  file::Model model;
  std::vector<BufferView> views;
  std::vector<ImageSource> images;
  std::vector<std::filesystem::path> beside;  // files that it refers to, relative to its folder
  size_t inputBytes = 0;                      // total of all files read
  Budget budget;
  Repairs repairs;

  // The memory to which `views` and `images` point.
  std::vector<std::vector<std::byte>> files;
  std::vector<std::unique_ptr<std::byte[]>> decoded;
};

// The JSON chunk and the binary chunk (empty if there is none) of a .glb, or the text of a .gltf.
struct Container {
  Bytes json;
  Bytes binary;
};
Container readContainer(Bytes file);

// Returns parsed, validated JSON. Throws Error(BadInput) if it is malformed or requires an unsupported extension.
JsonTree readJson(Bytes text);
// Returns the approximate memory of the JSON's tree in bytes; the result for text that is not JSON is arbitrary.
uint64_t treeBytes(Bytes json);

// Fills views and images from the file's buffers: the binary chunk, data URIs, and files within `enclosure`.
void readBuffers(Document& document, const nlohmann::json& root, const AllowedFolders& enclosure, Bytes binary);

// Returns the files to which buffers and images refer, relative to the document's folder.
std::vector<std::filesystem::path> externalFiles(const nlohmann::json& root);

// Decompresses bufferViews with EXT_meshopt_compression into document.views.
void decodeMeshopt(Document& document, const nlohmann::json& root, const std::vector<Bytes>& buffers);

void openDocument(Document& document, const std::filesystem::path& path, const AllowedFolders& enclosure);

// Throws Error(BadInput) that names the first unsupported required extension; warns about ignored extensions that
// affect the rendered image.
void checkExtensions(const nlohmann::json& root);

}  // namespace latelight::scene::gltf
