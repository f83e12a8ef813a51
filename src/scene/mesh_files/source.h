// Shared by all readers of mesh files: the bytes of the file, the scene under construction, and the frame of the file.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/allowed_folders.h"
#include "base/files.h"
#include "base/memory.h"
#include "scene/mesh_files/load.h"
#include "scene/mesh_files/text.h"
#include "scene/scene_builder.h"

namespace latelight::scene::mesh_files {

// The axes and the unit of a mesh file, which the file does not state.
struct Frame {
  bool yUp = true;
  double metersPerUnit = 1;
};

// Returns the frame that the options state, or the format's default: meters, with Y up for OBJ and Z up for PLY and
// STL, as Blender imports them (Blender 4.5 manual, Importing & Exporting Files). Throws Error(Usage) for unknown
// names.
Frame frameOf(MeshFormat format, const LoadOptions& options);

// The memory per vertex while a mesh is built, for its streams and the result together.
inline constexpr size_t kVertexBytes =
    2 * (sizeof(vec3) + sizeof(shared::VertexAttributes) + sizeof(shared::VertexExtra));

// A primitive of a node: one mesh with one material.
struct Primitive {
  Mesh mesh;
  uint32_t material = 0;
};

class Source {
 public:
  Source(const std::filesystem::path& path, MeshFormat format, const LoadOptions& options,
         const FileObserver& observer);

  // The file as text, without a byte-order mark.
  std::string_view text() const {
    return withoutByteOrderMark({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  }
  // Adds a node below the root, or the root itself if `name` is empty, with the primitives of its mesh. Primitives
  // without triangles are left out.
  uint32_t addNode(const std::string& name, uint32_t parent, std::vector<Primitive> primitives);
  // Claims memory for the time of loading.
  void claim(uint64_t size) { working.grow(size, "its contents"); }

  const std::filesystem::path path;
  const LoadOptions& options;
  const Frame frame;
  const FileBytes bytes;
  const AllowedFolders folders;
  SceneBuilder builder;
  MemoryClaim working;
  bool hasPoints = false;  // if spheres of LoadOptions::pointRadius stand for its points

 private:
  size_t pathBytes_ = 0;
};

// Drops triangles with a corner whose position is not finite, with a warning, and moves such vertices to a finite
// position. Throws Error(BadInput) if no triangle is left.
void dropBrokenTriangles(Mesh& mesh, const std::string& name);

void readObj(Source& source);
void readPly(Source& source);
void readStl(Source& source);

}  // namespace latelight::scene::mesh_files
