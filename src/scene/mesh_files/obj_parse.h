// The statements of an OBJ file (Wavefront, "Advanced Visualizer Manual", appendix B1), in the order of the file.
#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <vector>

#include "scene/scene.h"

namespace latelight::scene::mesh_files {

// Indices of a face's corner: from 0 on, or -1 if absent.
struct ObjCorner {
  int32_t position = -1, uv = -1, normal = -1;
};

enum class ObjKey : uint8_t { Object, Group, Material, Smoothing };

struct ObjStatement {
  ObjKey key = ObjKey::Object;
  std::string_view value;  // UTF-8
  size_t face = 0;         // it applies from this face of the block on
};

// A part of the file that one thread parses.
struct ObjBlock {
  std::string_view text;
  std::vector<vec3> positions, normals;
  std::vector<vec2> uv;             // v down, as in glTF
  std::vector<vec3> colors;         // sRGB-encoded; empty, or one per position
  std::vector<ObjCorner> corners;   // of all faces
  std::vector<uint32_t> faceSizes;  // corners per face
  std::vector<ObjStatement> statements;
  std::vector<std::string_view> materialLibraries;
  bool hasPoints = false, hasCurves = false;  // points and lines; free-form curves and surfaces
  std::deque<std::string> owned;              // lines that the file continues by "\", and converted names
};

struct ObjFile {
  std::vector<ObjBlock> blocks;
  std::vector<vec3> positions, normals;
  std::vector<vec2> uv;
  std::vector<vec3> colors;  // empty, or one per position
  bool hasDroppedIndices = false;
};

// Parses the file on all threads, checks every index, and moves the vertices from the blocks into one array each.
// Indices of texture coordinates and normals that do not exist become -1 (ObjFile::hasDroppedIndices). Throws
// Error(BadInput) that names the line.
ObjFile parseObj(std::string_view text);

}  // namespace latelight::scene::mesh_files
