// Builds the scene of a PLY file: a mesh per texture, with the vertices' normals, colors and texture coordinates under
// their usual names, or spheres for a point cloud.
//
// Faces are polygons (`vertex_indices`) or strips (`tristrips`, as the Stanford repository has them). Texture
// coordinates and colors may also belong to faces, as MeshLab writes them (`texcoord`, `texnumber`); corners then share
// no vertices. Integer colors are encoded as sRGB; floats are linear.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/error.h"
#include "base/log.h"
#include "base/parallel.h"
#include "scene/mesh_files/images.h"
#include "scene/mesh_files/ply_rows.h"
#include "scene/mesh_files/polygon.h"
#include "scene/mesh_files/source.h"
#include "scene/tangents.h"
#include "scene/vertices.h"
#include "shared/color.h"

namespace latelight::scene::mesh_files {
namespace {

constexpr uint64_t kMaxVertices = UINT32_MAX;

// The properties of a color, and its decoding to linear values.
class ColorReader {
 public:
  explicit ColorReader(const PlyElement& element)
      : columns_{element.find({"red", "diffuse_red", "r"}), element.find({"green", "diffuse_green", "g"}),
                 element.find({"blue", "diffuse_blue", "b"}), element.find({"alpha", "diffuse_alpha", "a"})} {
    if (!isPresent()) return;
    const PlyType type = element.properties[size_t(columns_[0])].type;
    if (isInteger(type)) scale_ = std::exp2(double(sizeOf(type) * 8)) - 1;
    if (type == PlyType::Int8 || type == PlyType::Int16 || type == PlyType::Int32) scale_ = 255;
  }
  bool isPresent() const { return columns_[0] >= 0 && columns_[1] >= 0 && columns_[2] >= 0; }
  vec4 read(const PlyRows& rows) const {
    vec4 color(1);
    for (int i = 0; i < 4; ++i) {
      if (columns_[size_t(i)] < 0) continue;
      const double value = rows.value(columns_[size_t(i)]) / (scale_ > 0 ? scale_ : 1);
      const float unit = std::isfinite(value) ? float(std::clamp(value, 0.0, 1.0)) : 1;
      color[i] = scale_ > 0 && i < 3 ? shared::linearFromSrgb(unit) : unit;
    }
    return color;
  }

 private:
  std::array<int, 4> columns_;
  double scale_ = 0;  // the value of 1; 0: floats
};

struct Faces {
  std::vector<uint32_t> indices;   // 3 per triangle
  std::vector<vec2> uv;            // per corner, or empty
  std::vector<vec4> colors;        // per triangle, or empty
  std::vector<uint32_t> textures;  // per triangle, or empty
  uint64_t skipped = 0;            // faces of fewer than 3 corners
};

class PlyReader {
 public:
  explicit PlyReader(Source& source)
      : source_(source), header_(readPlyHeader(source.text())), rows_(source.text(), header_), images_(source) {}

  void run() {
    const auto vertex = std::ranges::find(header_.elements, "vertex", &PlyElement::name);
    if (vertex == header_.elements.end() || vertex->count == 0)
      badInput("it has no vertices: its element \"vertex\" is missing or empty");
    const bool readFirst = std::any_of(header_.elements.begin(), vertex, hasFaces);  // faces refer to its rows
    if (readFirst) {
      std::for_each(header_.elements.begin(), vertex, [&](const PlyElement& element) { skip(element); });
      readElement(*vertex);
      rows_.rewind();
    }
    for (const PlyElement& element : header_.elements) {
      if (readFirst && &element == &*vertex)
        skip(element);
      else
        readElement(element);
    }
    addMaterials();
    if (!faces_.indices.empty())
      addMeshes();
    else
      addPoints();
    if (faces_.skipped > 0) warn("{}: {} faces have fewer than 3 corners, and are left out", name(), faces_.skipped);
    if (source_.options.textures) images_.decode();
  }

 private:
  std::string name() const { return source_.path.string(); }

  // Returns the list of corners, or -1 for an element that is neither faces nor strips.
  static int cornersIn(const PlyElement& element) {
    const int list = element.find({"vertex_indices", "vertex_index"});
    const bool isKnown = element.name == "face" || element.name == "tristrips";
    return isKnown && list >= 0 && element.properties[size_t(list)].isList() ? list : -1;
  }
  static bool hasFaces(const PlyElement& element) { return cornersIn(element) >= 0; }

  void readElement(const PlyElement& element) {
    if (element.name != "vertex" && !hasFaces(element)) return skip(element);
    rows_.begin(element);
    if (element.name == "vertex") return readVertices(element);
    return element.name == "face" ? readFaces(element, cornersIn(element)) : readStrips(element, cornersIn(element));
  }

  void skip(const PlyElement& element) {
    rows_.begin(element);
    for (uint64_t i = 0; i < element.count; ++i) rows_.next();
  }

  // --- vertices -----------------------------------------------------------------------------------------------------

  static int scalar(const PlyElement& element, std::initializer_list<std::string_view> names) {
    const int at = element.find(names);
    return at >= 0 && !element.properties[size_t(at)].isList() ? at : -1;
  }

  void readVertices(const PlyElement& element) {
    const std::array x{scalar(element, {"x"}), scalar(element, {"y"}), scalar(element, {"z"})};
    const std::array n{scalar(element, {"nx", "normal_x"}), scalar(element, {"ny", "normal_y"}),
                       scalar(element, {"nz", "normal_z"})};
    const std::array uv{scalar(element, {"u", "s", "texture_u", "texture_s", "tu"}),
                        scalar(element, {"v", "t", "texture_v", "texture_t", "tv"})};
    const ColorReader color(element);
    if (!vertices_.positions.empty()) badInput("it has more than one element \"vertex\"");
    if (x[0] < 0 || x[1] < 0 || x[2] < 0) badInput("its element \"vertex\" has no properties x, y and z");
    if (element.count > kMaxVertices)
      badInput("it has {} vertices, more than the limit of {}", element.count, kMaxVertices);
    source_.claim(element.count * kVertexBytes);
    const auto reserve = [&](auto& stream, bool isPresent) {
      stream.clear();
      if (isPresent) stream.resize(element.count);
    };
    reserve(vertices_.positions, true);
    reserve(vertices_.normals, n[0] >= 0 && n[1] >= 0 && n[2] >= 0);
    reserve(vertices_.uv[0], uv[0] >= 0 && uv[1] >= 0);
    reserve(vertices_.colors, color.isPresent());
    rows_.forEach([&](const PlyRows& rows, uint64_t i) {
      const auto value = [&](int column) { return float(rows.value(column)); };
      vertices_.positions[i] = {value(x[0]), value(x[1]), value(x[2])};
      if (!vertices_.normals.empty()) vertices_.normals[i] = {value(n[0]), value(n[1]), value(n[2])};
      if (!vertices_.uv[0].empty()) vertices_.uv[0][i] = usable({value(uv[0]), 1 - value(uv[1])});
      if (color.isPresent()) vertices_.colors[i] = color.read(rows);
    });
  }

  static vec2 usable(vec2 uv) { return std::isfinite(uv.x) && std::isfinite(uv.y) ? uv : vec2(0); }

  // --- faces --------------------------------------------------------------------------------------------------------

  void readFaces(const PlyElement& element, int list) {
    const int uv = element.find({"texcoord"}), texture = scalar(element, {"texnumber"});
    const bool hasUv = uv >= 0 && element.properties[size_t(uv)].isList();
    const ColorReader color(element);
    if (!hasUv && !color.isPresent() && texture < 0 && faces_.indices.empty() && element.count <= kMaxVertices / 3) {
      if (auto triangles = rows_.readTriangles(list, vertices_.positions.size())) {
        faces_.indices = std::move(*triangles);
        return claimFaces();
      }
    }
    completeFaces(hasUv, color.isPresent(), texture >= 0);
    std::vector<vec3> corners;
    std::vector<std::array<uint32_t, 3>> triangles;
    for (uint64_t row = 0; row < element.count; ++row) {
      rows_.next();
      const std::vector<double>& face = rows_.list(list);
      if (face.size() < 3) {
        ++faces_.skipped;
        continue;
      }
      triangles.clear();
      if (face.size() == 3) {
        triangles.push_back({0, 1, 2});
        for (const double index : face) check(index);
      } else {
        corners.clear();
        for (const double index : face) corners.push_back(vertices_.positions[check(index)]);
        triangulate(corners, triangles);
      }
      for (const auto& triangle : triangles) {
        for (const uint32_t corner : triangle) faces_.indices.push_back(uint32_t(face[corner]));
        if (hasUv) addCornerUv(triangle, rows_.list(uv));
        if (color.isPresent()) faces_.colors.push_back(color.read(rows_));
        if (texture >= 0) faces_.textures.push_back(textureAt(rows_.value(texture)));
      }
    }
    claimFaces();
  }

  void addCornerUv(const std::array<uint32_t, 3>& triangle, const std::vector<double>& uv) {
    for (const uint32_t corner : triangle) {
      const size_t at = 2 * size_t{corner};
      faces_.uv.push_back(at + 1 < uv.size() ? usable({float(uv[at]), 1 - float(uv[at + 1])}) : vec2(0));
    }
  }

  uint32_t textureAt(double number) const {
    return number >= 0 && number < double(header_.textures.size()) ? uint32_t(number) : 0;
  }

  uint32_t check(double index) const {
    if (!(index >= 0 && index < double(vertices_.positions.size())) || index != std::floor(index))
      badInput("face {} refers to vertex {}, but there are {} vertices, numbered from 0", rows_.row(), index,
               vertices_.positions.size());
    return uint32_t(index);
  }

  // -1 ends a strip.
  void readStrips(const PlyElement& element, int list) {
    for (uint64_t row = 0; row < element.count; ++row) {
      rows_.next();
      const std::vector<double>& strip = rows_.list(list);
      size_t begin = 0;
      for (size_t i = 0; i < strip.size(); ++i) {
        if (strip[i] == -1) {
          begin = i + 1;
          continue;
        }
        check(strip[i]);
        if (i < begin + 2) continue;
        const bool isOdd = (i - begin) % 2 == 1;
        for (const size_t corner : {i - 2, isOdd ? i : i - 1, isOdd ? i - 1 : i})
          faces_.indices.push_back(uint32_t(strip[corner]));
      }
    }
    claimFaces();
  }

  // Gives the triangles so far values of each stream that is requested or that some of them have.
  void completeFaces(bool uv, bool colors, bool textures) {
    const size_t corners = faces_.indices.size();
    if (uv || !faces_.uv.empty()) faces_.uv.resize(corners, vec2(0));
    if (colors || !faces_.colors.empty()) faces_.colors.resize(corners / 3, vec4(1));
    if (textures || !faces_.textures.empty()) faces_.textures.resize(corners / 3, 0);
  }

  void claimFaces() {
    completeFaces(false, false, false);
    const bool isFlat = vertices_.normals.empty() || !faces_.uv.empty() || !faces_.colors.empty();
    source_.claim(faces_.indices.size() * (sizeof(uint32_t) + (isFlat ? kVertexBytes : 0)));
    if (faces_.indices.size() > kMaxVertices) badInput("it has more than {} triangles: split it", kMaxVertices / 3);
  }

  // --- the scene ----------------------------------------------------------------------------------------------------

  bool isTranslucent() const {
    const std::vector<vec4>& colors = faces_.colors.empty() ? vertices_.colors : faces_.colors;
    const auto isClear = [](const vec4& color) { return color.a < 1; };
    const auto isVisible = [](const vec4& color) { return color.a > 0; };
    return std::ranges::any_of(colors, isClear) && std::ranges::any_of(colors, isVisible);
  }

  // Alpha that is 0 everywhere is an unused channel.
  void ignoreUnusedAlpha() {
    for (std::vector<vec4>* colors : {&vertices_.colors, &faces_.colors})
      if (std::ranges::all_of(*colors, [](const vec4& color) { return color.a == 0; }))
        for (vec4& color : *colors) color.a = 1;
  }

  void addMaterials() {
    ignoreUnusedAlpha();
    const bool hasUv = !faces_.uv.empty() || !vertices_.uv[0].empty();
    const bool hasColors = !faces_.colors.empty() || !vertices_.colors.empty();
    const size_t count = hasUv ? std::max<size_t>(header_.textures.size(), 1) : 1;
    for (size_t i = 0; i < count; ++i) {
      Material material = plainMaterial(count > 1 ? fmt::format("material{}", i) : "default",
                                        vec3(hasColors || (hasUv && !header_.textures.empty()) ? 1 : 0.8f), 0, 0.5f);
      if (isTranslucent()) material.data.flags |= shared::kMaterialBlended;
      const bool isRequested = (source_.options.textureSlots & 1u << shared::kTextureBaseColor) != 0;
      if (hasUv && i < header_.textures.size() && source_.options.textures && isRequested)
        addTexture(header_.textures[i], material);
      source_.builder.scene.materials.push_back(std::move(material));
    }
  }

  void addTexture(std::string file, Material& material) {
    std::ranges::replace(file, '\\', '/');
    if (!images_.isReadable(file)) return;
    material.slots[shared::kTextureBaseColor].texture = images_.request({.first = {.file = file}, .srgb = true});
    material.data.textures |= 1u << shared::kTextureBaseColor;
  }

  // Gives each corner a vertex of its own, with the values that belong to faces.
  void unshare() {
    const auto expand = [&](auto& stream) {
      if (stream.empty()) return;
      auto corners = std::remove_reference_t<decltype(stream)>(faces_.indices.size());
      for (size_t i = 0; i < corners.size(); ++i) corners[i] = stream[faces_.indices[i]];
      stream = std::move(corners);
    };
    expand(vertices_.positions);
    expand(vertices_.normals);
    expand(vertices_.colors);
    expand(vertices_.uv[0]);
    if (!faces_.uv.empty()) vertices_.uv[0] = std::move(faces_.uv);
    if (!faces_.colors.empty()) {
      vertices_.colors.resize(faces_.indices.size());
      for (size_t i = 0; i < vertices_.colors.size(); ++i) vertices_.colors[i] = faces_.colors[i / 3];
    }
    for (size_t i = 0; i < faces_.indices.size(); ++i) faces_.indices[i] = uint32_t(i);
  }

  void addMeshes() {
    const size_t materials = source_.builder.scene.materials.size();
    if (!faces_.uv.empty() || !faces_.colors.empty() || materials > 1) unshare();
    std::vector<Primitive> primitives(materials);
    if (materials == 1) {
      primitives[0].mesh = build(std::move(vertices_), std::move(faces_.indices));
    } else {
      faces_.textures.resize(faces_.indices.size() / 3);
      for (uint32_t i = 0; i < materials; ++i) {
        primitives[i].material = i;
        auto [vertices, indices] = ofTexture(i);
        if (!indices.empty()) primitives[i].mesh = build(std::move(vertices), std::move(indices));
      }
    }
    source_.addNode("", SceneBuilder::kRoot, std::move(primitives));
  }

  // Returns the triangles of one texture, of which no two share a vertex.
  std::pair<Vertices, std::vector<uint32_t>> ofTexture(uint32_t texture) const {
    Vertices some;
    std::vector<uint32_t> indices;
    const auto copy = [](const auto& from, auto& to, size_t at) {
      if (!from.empty()) to.push_back(from[at]);
    };
    for (size_t i = 0; i < faces_.indices.size(); ++i) {
      if (faces_.textures[i / 3] != texture) continue;
      copy(vertices_.positions, some.positions, i);
      copy(vertices_.normals, some.normals, i);
      copy(vertices_.colors, some.colors, i);
      copy(vertices_.uv[0], some.uv[0], i);
      indices.push_back(uint32_t(indices.size()));
    }
    return {std::move(some), std::move(indices)};
  }

  Mesh build(Vertices vertices, std::vector<uint32_t> indices) const {
    if (vertices.normals.empty())
      makeFlatNormals(vertices, indices);
    else if (!repairNormals(vertices, indices).empty())
      warn("{} has normals that point into its surface, which are turned over", name());
    if (source_.options.tangents) makeTangents(TangentSpace(), vertices, indices);
    Mesh mesh = pack(std::move(vertices), std::move(indices));
    dropBrokenTriangles(mesh, name());
    return mesh;
  }

  // --- points -------------------------------------------------------------------------------------------------------

  void addPoints() {
    const size_t count = vertices_.positions.size();
    if (!source_.options.pointRadius && faces_.skipped > 0)
      badInput(
          "none of its {} faces has at least 3 corners: export it again with its faces, or set --point-radius to show "
          "its points as spheres",
          faces_.skipped);
    if (!source_.options.pointRadius)
      badInput(
          "it has {} points and no faces: set --point-radius to the radius in meters of the spheres that are to stand "
          "for them",
          count);
    constexpr size_t kCorners = 12, kTriangles = 20;  // of an icosahedron
    if (count > kMaxVertices / (3 * kTriangles))
      badInput("it has {} points, too many to be spheres: thin them out", count);
    source_.hasPoints = true;
    source_.claim(count * (kCorners * kVertexBytes + 3 * kTriangles * sizeof(uint32_t)));
    const float radius = float(double{*source_.options.pointRadius} / source_.frame.metersPerUnit);
    std::vector<Primitive> primitives(1);
    Mesh& mesh = primitives[0].mesh;
    mesh.positions.resize(count * kCorners);
    mesh.attributes.resize(count * kCorners);
    if (!vertices_.colors.empty()) mesh.extras.resize(count * kCorners);
    mesh.indices.resize(count * kTriangles * 3);
    parallelFor(count, 4096, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) addSphere(mesh, i, radius);
    });
    dropBrokenTriangles(mesh, name());
    source_.addNode("", SceneBuilder::kRoot, std::move(primitives));
  }

  // Writes the icosahedron of point `i`, whose corners lie at the radius and have the normals of a sphere.
  void addSphere(Mesh& mesh, size_t i, float radius) const {
    constexpr float kGolden = std::numbers::phi_v<float>;
    static constexpr std::array<std::array<float, 3>, 12> kCorners{{{-1, kGolden, 0},
                                                                    {1, kGolden, 0},
                                                                    {-1, -kGolden, 0},
                                                                    {1, -kGolden, 0},
                                                                    {0, -1, kGolden},
                                                                    {0, 1, kGolden},
                                                                    {0, -1, -kGolden},
                                                                    {0, 1, -kGolden},
                                                                    {kGolden, 0, -1},
                                                                    {kGolden, 0, 1},
                                                                    {-kGolden, 0, -1},
                                                                    {-kGolden, 0, 1}}};
    static constexpr std::array<uint8_t, 60> kIndices{
        0, 11, 5, 0, 5, 1, 0, 1, 7, 0, 7, 10, 0, 10, 11, 1, 5, 9, 5, 11, 4,  11, 10, 2,  10, 7, 6, 7, 1, 8,
        3, 9,  4, 3, 4, 2, 3, 2, 6, 3, 6, 8,  3, 8,  9,  4, 9, 5, 2, 4,  11, 6,  2,  10, 8,  6, 7, 9, 8, 1};
    const size_t first = i * kCorners.size();
    for (size_t c = 0; c < kCorners.size(); ++c) {
      const vec3 normal = glm::normalize(vec3(kCorners[c][0], kCorners[c][1], kCorners[c][2]));
      mesh.positions[first + c] = vertices_.positions[i] + radius * normal;
      mesh.attributes[first + c] = {normal, vec4(0), vec2(0)};
      if (!mesh.extras.empty()) mesh.extras[first + c] = {vec2(0), vertices_.colors[i]};
    }
    for (size_t k = 0; k < kIndices.size(); ++k) mesh.indices[i * kIndices.size() + k] = uint32_t(first + kIndices[k]);
  }

  Source& source_;
  const PlyHeader header_;
  PlyRows rows_;
  Images images_;
  Vertices vertices_;
  Faces faces_;
};

}  // namespace

void readPly(Source& source) {
  PlyReader(source).run();
}

}  // namespace latelight::scene::mesh_files
