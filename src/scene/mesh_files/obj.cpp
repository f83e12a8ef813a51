// Builds the scene of an OBJ file. Objects are nodes, and groups are nodes below their object; each has a primitive per
// material. Corners that agree in position, texture coordinates and normal share a vertex. Faces without normals are
// flat, or smooth within their smoothing group: the normals of the faces around a position, weighted by area.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <span>
#include <tuple>
#include <utility>

#include "base/error.h"
#include "base/log.h"
#include "base/parallel.h"
#include "base/text.h"
#include "scene/mesh_files/mtl.h"
#include "scene/mesh_files/obj_parse.h"
#include "scene/mesh_files/polygon.h"
#include "scene/mesh_files/source.h"
#include "scene/mesh_files/text.h"
#include "scene/tangents.h"
#include "scene/vertices.h"
#include "shared/color.h"

namespace latelight::scene::mesh_files {
namespace {

// Consecutive faces of a block with the same state.
struct Run {
  size_t block = 0, firstFace = 0, lastFace = 0;  // faces [firstFace, lastFace)
  size_t firstCorner = 0;
  uint32_t smoothing = 0;  // 0: flat
};

// The faces of a node with one material.
struct Part {
  std::string_view object, group, material;
  std::vector<Run> runs;
};

// Finds the vertex of a corner. A hash table with open addressing; a search that is longer than kMaxProbes, which only
// a file made for it causes, is given up for another vertex.
class CornerTable {
 public:
  explicit CornerTable(size_t expected) : slots_(std::bit_ceil(std::max<size_t>(1024, 2 * expected + 2)), kNone) {
    corners_.reserve(expected);
  }
  // Returns the index of the corner's vertex, which is that of `next` if it is new.
  uint32_t insert(const ObjCorner& corner) {
    if (2 * (corners_.size() + 1) > slots_.size()) grow();
    const size_t mask = slots_.size() - 1;
    size_t slot = hash(corner) & mask;
    for (size_t probe = 0; probe < kMaxProbes; ++probe, slot = (slot + 1) & mask) {
      if (slots_[slot] == kNone) {
        slots_[slot] = static_cast<uint32_t>(corners_.size());
        break;
      }
      const ObjCorner& other = corners_[slots_[slot]];
      if (other.position == corner.position && other.uv == corner.uv && other.normal == corner.normal)
        return slots_[slot];
    }
    corners_.push_back(corner);
    return static_cast<uint32_t>(corners_.size() - 1);
  }
  const std::vector<ObjCorner>& corners() const { return corners_; }  // one per vertex

 private:
  static constexpr uint32_t kNone = ~0u;
  static constexpr size_t kMaxProbes = 256;

  // Corners with three equal indices, or with only a position, are hashed to consecutive slots, which keeps the table's
  // accesses as local as the file's.
  static size_t hash(const ObjCorner& c) {
    const auto offset = [&](int32_t index) { return index < 0 ? 0u : uint32_t(index) - uint32_t(c.position); };
    return uint32_t(c.position) + uint64_t{offset(c.uv)} * 0x9E3779B97F4A7C15ull / 8 +
           uint64_t{offset(c.normal)} * 0xC2B2AE3D27D4EB4Full / 8;
  }
  void grow() {
    slots_.assign(slots_.size() * 2, kNone);
    for (uint32_t i = 0; i < corners_.size(); ++i) {
      size_t slot = hash(corners_[i]) & (slots_.size() - 1);
      for (size_t probe = 0; probe < kMaxProbes; ++probe, slot = (slot + 1) & (slots_.size() - 1))
        if (slots_[slot] == kNone) {
          slots_[slot] = i;
          break;
        }
    }
  }

  std::vector<ObjCorner> corners_;
  std::vector<uint32_t> slots_;
};

// Sums of normals per position and smoothing group, as a chain per position.
class SmoothNormals {
 public:
  explicit SmoothNormals(size_t positions) : heads_(positions, -1) {}

  // Returns the index of the sum, or -1 if the position has too many smoothing groups.
  int32_t find(int32_t position, uint32_t group) {
    constexpr int kMaxGroups = 64;
    int length = 0;
    for (int32_t at = heads_[size_t(position)]; at >= 0; at = entries_[size_t(at)].next, ++length)
      if (entries_[size_t(at)].group == group) return at;
    if (length >= kMaxGroups) return -1;
    entries_.push_back({.group = group, .next = heads_[size_t(position)]});
    return heads_[size_t(position)] = static_cast<int32_t>(entries_.size() - 1);
  }
  void add(int32_t entry, const glm::dvec3& normal) { entries_[size_t(entry)].sum += normal; }
  size_t size() const { return entries_.size(); }
  glm::dvec3 sum(size_t entry) const { return entries_[entry].sum; }

 private:
  struct Entry {
    uint32_t group;
    int32_t next;
    glm::dvec3 sum{0};
  };
  std::vector<int32_t> heads_;
  std::vector<Entry> entries_;
};

vec3 unitOr(glm::dvec3 normal, vec3 otherwise) {
  const double length = glm::length(normal);
  return length > 0 && std::isfinite(length) ? vec3(normal / length) : otherwise;
}

class ObjReader {
 public:
  explicit ObjReader(Source& source) : source_(source), images_(source) {}

  void run() {
    if (source_.text().starts_with("\xff\xfe") || source_.text().starts_with("\xfe\xff"))
      badInput("it is UTF-16 text: save it as UTF-8");
    source_.claim(source_.bytes.size());  // the parsed numbers have about the size of their text
    file_ = parseObj(source_.text());
    warnAboutFile();
    collectParts();
    if (parts_.empty()) badInput("it has no faces: statements \"f\" define the surfaces of an OBJ file");
    computeNormals();
    readLibraries();
    addMaterials();
    addNodes();
    if (source_.options.textures) images_.decode();
  }

 private:
  std::string name() const { return source_.path.string(); }

  void warnAboutFile() const {
    if (file_.hasDroppedIndices)
      warn("{}: faces refer to texture coordinates or normals that do not exist, and go without them", name());
    if (std::ranges::any_of(file_.blocks, &ObjBlock::hasPoints))
      warn("{}: points and lines are not supported, and are left out", name());
    if (std::ranges::any_of(file_.blocks, &ObjBlock::hasCurves))
      warn("{}: free-form curves and surfaces are not supported, and are left out", name());
  }

  // --- parts --------------------------------------------------------------------------------------------------------

  // Follows the statements that say to what the next faces belong.
  void collectParts() {
    std::map<std::tuple<std::string_view, std::string_view, std::string_view>, size_t> known;
    std::string_view object, group, material;
    uint32_t smoothing = 0;
    for (size_t i = 0; i < file_.blocks.size(); ++i) {
      const ObjBlock& block = file_.blocks[i];
      Run run{.block = i};
      const auto finish = [&](size_t lastFace) {
        run.lastFace = lastFace;
        run.smoothing = smoothing;
        if (run.firstFace < lastFace) {
          const auto [at, isNew] = known.try_emplace({object, group, material}, parts_.size());
          if (isNew) parts_.push_back({object, group, material, {}});
          parts_[at->second].runs.push_back(run);
        }
        for (; run.firstFace < lastFace; ++run.firstFace) run.firstCorner += block.faceSizes[run.firstFace];
      };
      for (const ObjStatement& statement : block.statements) {
        finish(statement.face);
        if (statement.key == ObjKey::Object) object = statement.value, group = {};
        if (statement.key == ObjKey::Group) group = statement.value;
        if (statement.key == ObjKey::Material) material = statement.value;
        if (statement.key == ObjKey::Smoothing) smoothing = smoothingGroup(statement.value);
      }
      finish(block.faceSizes.size());
    }
    source_.claim(parts_.size() * (sizeof(Part) + sizeof(Mesh) + sizeof(Node) + sizeof(Instance)));
  }

  static uint32_t smoothingGroup(std::string_view value) {
    if (value == "on") return 1;
    return parseNumber<uint32_t>(value).value_or(0);
  }

  // Calls visit(corners, run) for each face of a part.
  template <typename Visit>
  void eachFace(const Part& part, const Visit& visit) {
    for (const Run& run : part.runs) {
      ObjBlock& block = file_.blocks[run.block];
      size_t at = run.firstCorner;
      for (size_t face = run.firstFace; face < run.lastFace; at += block.faceSizes[face++])
        visit(std::span(block.corners).subspan(at, block.faceSizes[face]), run);
    }
  }

  // --- normals ------------------------------------------------------------------------------------------------------

  static bool lacksNormals(std::span<const ObjCorner> face) {
    return std::ranges::any_of(face, [](const ObjCorner& corner) { return corner.normal < 0; });
  }

  glm::dvec3 normalOf(std::span<const ObjCorner> face) {
    polygon_.clear();
    for (const ObjCorner& corner : face) polygon_.push_back(file_.positions[size_t(corner.position)]);
    return polygonNormal(polygon_);
  }

  // Adds a normal for each corner that has none: one per face, or one per position and smoothing group.
  void computeNormals() {
    givenNormals_ = file_.normals.size();
    SmoothNormals smooth(hasSmoothFaces() ? file_.positions.size() : 0);
    for (const Part& part : parts_)
      eachFace(part, [&](std::span<ObjCorner> face, const Run& run) {
        if (run.smoothing == 0 || !lacksNormals(face)) return;
        const glm::dvec3 normal = normalOf(face);
        for (const ObjCorner& corner : face)
          if (const int32_t sum = smooth.find(corner.position, run.smoothing); sum >= 0) smooth.add(sum, normal);
      });
    const size_t firstSmooth = file_.normals.size();
    source_.claim(smooth.size() * 4 * sizeof(vec3));
    for (size_t i = 0; i < smooth.size(); ++i) file_.normals.push_back(unitOr(smooth.sum(i), vec3(0, 0, 1)));
    for (const Part& part : parts_)
      eachFace(part, [&](std::span<ObjCorner> face, const Run& run) {
        if (lacksNormals(face)) fillNormals(face, run.smoothing, smooth, firstSmooth);
      });
  }

  bool hasSmoothFaces() const {
    return std::ranges::any_of(parts_, [](const Part& part) {
      return std::ranges::any_of(part.runs, [](const Run& run) { return run.smoothing != 0; });
    });
  }

  void fillNormals(std::span<ObjCorner> face, uint32_t smoothing, SmoothNormals& smooth, size_t firstSmooth) {
    int32_t flat = -1;
    for (ObjCorner& corner : face) {
      if (corner.normal >= 0) continue;
      const int32_t sum = smoothing == 0 ? -1 : smooth.find(corner.position, smoothing);
      if (sum < 0 && flat < 0) {
        flat = static_cast<int32_t>(file_.normals.size());
        file_.normals.push_back(unitOr(normalOf(face), vec3(0, 0, 1)));
      }
      corner.normal = sum < 0 ? flat : static_cast<int32_t>(firstSmooth) + sum;
    }
  }

  // --- materials ----------------------------------------------------------------------------------------------------

  void readLibraries() {
    for (const ObjBlock& block : file_.blocks)
      for (const std::string_view names : block.materialLibraries) {
        if (readLibrary(std::string(unquoted(names)))) continue;  // one name, which may contain blanks
        Words words(names);
        const bool isOne = names.find_first_of(" \t") == std::string_view::npos;
        for (std::string_view word = words.word(); !word.empty(); word = words.word())
          if (isOne || !readLibrary(std::string(word)))
            warn("{}: the material library {} does not exist, and is left out", name(), shortened(printable(word)));
      }
  }

  // Returns false if the file does not exist.
  bool readLibrary(std::string file) {
    std::ranges::replace(file, '\\', '/');
    if (file.empty() || !source_.folders.exists(file)) return false;
    std::vector<std::byte> bytes;
    try {
      bytes = source_.folders.read(file);
    } catch (const Error& error) {
      throw Error(error.code(), fmt::format("a material library {}", error.what()));
    }
    source_.claim(2 * bytes.size());
    readMtl({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, file, library_);
    source_.builder.scene.files.push_back(source_.path.parent_path() / file);
    return true;
  }

  void addMaterials() {
    std::vector<Material>& materials = source_.builder.scene.materials;
    for (const Part& part : parts_) {
      const auto [known, isNew] = materialOf_.try_emplace(part.material, uint32_t(materials.size()));
      if (!isNew) continue;
      const auto found = library_.find(part.material);
      if (found != library_.end()) {
        materials.push_back(convert(found->second, source_.options, images_));
        continue;
      }
      if (!part.material.empty())
        warn("{}: no material library defines the material {}: it is gray", name(),
             shortened(printable(part.material)));
      materials.push_back(plainMaterial(part.material.empty() ? "default" : std::string(part.material),
                                        vec3(file_.colors.empty() ? 0.8f : 1), 0, 0.5f));
    }
  }

  // --- meshes -------------------------------------------------------------------------------------------------------

  Mesh build(const Part& part) {
    std::vector<uint32_t> indices;
    const CornerTable table = collect(part, indices);
    const size_t count = table.corners().size();
    source_.claim(count * kVertexBytes + 2 * indices.size() * sizeof(uint32_t));
    Vertices vertices = gather(table.corners());
    const bool isGiven = std::ranges::any_of(
        table.corners(), [&](const ObjCorner& corner) { return size_t(corner.normal) < givenNormals_; });
    if (isGiven && !repairNormals(vertices, indices).empty())
      warn("{} has normals that point into its surface, which are turned over", name());
    const Material& material = source_.builder.scene.materials[materialOf_.at(part.material)];
    if (const auto space = tangentSpaceOf(material, source_.options)) makeTangents(*space, vertices, indices);
    Mesh mesh = pack(std::move(vertices), std::move(indices));
    dropBrokenTriangles(mesh, name());
    return mesh;
  }

  size_t cornersOf(const Part& part) const {
    size_t corners = 0;
    for (const Run& run : part.runs) {
      const std::span sizes(file_.blocks[run.block].faceSizes);
      for (const uint32_t size : sizes.subspan(run.firstFace, run.lastFace - run.firstFace)) corners += size;
    }
    return corners;
  }

  // Triangulates the part's faces, and numbers their vertices.
  CornerTable collect(const Part& part, std::vector<uint32_t>& indices) {
    const size_t corners = cornersOf(part);
    CornerTable table(std::min(corners, file_.positions.size()));
    indices.reserve(corners);
    std::vector<vec3> polygon;
    std::vector<std::array<uint32_t, 3>> triangles;
    eachFace(part, [&](std::span<const ObjCorner> face, const Run&) {
      if (face.size() == 3) {
        for (const ObjCorner& corner : face) indices.push_back(table.insert(corner));
        return;
      }
      polygon.clear();
      triangles.clear();
      for (const ObjCorner& corner : face) polygon.push_back(file_.positions[size_t(corner.position)]);
      triangulate(polygon, triangles);
      for (const auto& triangle : triangles)
        for (const uint32_t corner : triangle) indices.push_back(table.insert(face[corner]));
    });
    return table;
  }

  Vertices gather(const std::vector<ObjCorner>& corners) const {
    Vertices v;
    const bool hasUv = std::ranges::any_of(corners, [](const ObjCorner& corner) { return corner.uv >= 0; });
    v.positions.resize(corners.size());
    v.normals.resize(corners.size());
    if (hasUv) v.uv[0].resize(corners.size());
    if (!file_.colors.empty()) v.colors.resize(corners.size());
    parallelFor(corners.size(), 16384, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        const ObjCorner& corner = corners[i];
        v.positions[i] = file_.positions[size_t(corner.position)];
        v.normals[i] = file_.normals[size_t(corner.normal)];
        if (hasUv && corner.uv >= 0) v.uv[0][i] = file_.uv[size_t(corner.uv)];
        if (!file_.colors.empty()) v.colors[i] = vec4(shared::linearFromSrgb(file_.colors[size_t(corner.position)]), 1);
      }
    });
    return v;
  }

  // --- nodes --------------------------------------------------------------------------------------------------------

  // Builds all meshes, then adds a node per object and group, in the order of their first faces.
  void addNodes() {
    std::vector<Primitive> primitives(parts_.size());
    parallelFor(parts_.size(), 1, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) primitives[i] = {build(parts_[i]), materialOf_.at(parts_[i].material)};
    });
    std::map<std::pair<std::string_view, std::string_view>, std::vector<size_t>> partsOf;
    std::vector<std::pair<std::string_view, std::string_view>> order;
    for (size_t i = 0; i < parts_.size(); ++i) {
      std::vector<size_t>& parts = partsOf[{parts_[i].object, parts_[i].group}];
      if (parts.empty()) order.emplace_back(parts_[i].object, parts_[i].group);
      parts.push_back(i);
    }
    // Objects first, so that each is there before its groups.
    std::map<std::string_view, uint32_t> objects{{std::string_view(), SceneBuilder::kRoot}};
    for (const auto& [object, group] : order) {
      const auto [at, isNew] = objects.try_emplace(object, 0);
      const auto own = partsOf.find({object, std::string_view()});
      const bool hasOwn = own != partsOf.end() && (isNew || object.empty());
      std::vector<Primitive> ofObject;
      if (hasOwn && !own->second.empty())
        for (const size_t part : std::exchange(own->second, {})) ofObject.push_back(std::move(primitives[part]));
      if (isNew || !ofObject.empty())
        at->second = source_.addNode(std::string(object), SceneBuilder::kRoot, std::move(ofObject));
      if (group.empty()) continue;
      std::vector<Primitive> ofGroup;
      for (const size_t part : partsOf[{object, group}]) ofGroup.push_back(std::move(primitives[part]));
      source_.addNode(std::string(group), at->second, std::move(ofGroup));
    }
  }

  Source& source_;
  Images images_;
  ObjFile file_;
  std::vector<Part> parts_;
  std::vector<vec3> polygon_;
  size_t givenNormals_ = 0;  // those of the file come first in file_.normals
  std::map<std::string, MtlMaterial, std::less<>> library_;
  std::map<std::string_view, uint32_t> materialOf_;
};

}  // namespace

void readObj(Source& source) {
  ObjReader(source).run();
}

}  // namespace latelight::scene::mesh_files
