// PLY files in the three encodings, with the names that programs give to their properties.
#include <cmath>

#include "base/log.h"
#include "mesh_files/support.h"

namespace latelight::scene::test {
namespace {

using testing::HasSubstr;

struct Encoding {
  const char* format;
  bool isText, isBigEndian;
};
class Ply : public testing::TestWithParam<Encoding> {
 protected:
  template <typename T>
  std::string values(const std::vector<T>& numbers) const {
    if (!GetParam().isText) return bytesOf(numbers, GetParam().isBigEndian);
    std::string text;
    for (const T number : numbers) text += fmt::format("{} ", +number);
    return text + "\n";
  }
  std::string start() const { return fmt::format("ply\nformat {} 1.0\ncomment a test\n", GetParam().format); }
};
INSTANTIATE_TEST_SUITE_P(Encodings, Ply,
                         testing::Values(Encoding{"ascii", true, false}, Encoding{"binary_little_endian", false, false},
                                         Encoding{"binary_big_endian", false, true}),
                         [](const auto& info) { return std::string(info.param.format); });

constexpr const char* kPosition = "property float x\nproperty float32 y\nproperty double z\n";

TEST_P(Ply, PolygonsBecomeTriangles) {
  // A square, and a chevron that a fan about its first corner would not stay within.
  std::string text = start() + "element vertex 8\n" + kPosition +
                     "element face 2\nproperty list uchar int vertex_indices\nend_header\n";
  const std::vector<vec3> positions = {{0, 0, 0}, {1, 0, 0},  {1, 1, 0}, {0, 1, 0},
                                       {0, 3, 0}, {-2, 0, 0}, {0, 1, 0}, {2, 0, 0}};
  for (const vec3& p : positions) text += values<float>({p.x, p.y}) + values<double>({p.z});
  for (const uint8_t first : {uint8_t{0}, uint8_t{4}})
    text += values<uint8_t>({4}) + values<int32_t>({first, first + 1, first + 2, first + 3});
  const Scene scene = MeshFile("a.ply", text).load();
  EXPECT_FALSE(scene.yUp);
  const std::vector<dvec3> corners = cornersOf(scene);
  ASSERT_EQ(corners.size(), 12u);
  double area = 0;
  for (size_t i = 0; i < corners.size(); i += 3) {
    const double twice = glm::cross(corners[i + 1] - corners[i], corners[i + 2] - corners[i]).z;
    EXPECT_GT(twice, 0) << "triangle " << i / 3;
    area += twice / 2;
  }
  EXPECT_NEAR(area, 1 + 4, 1e-9);  // the chevron: two triangles of 2 x 2 / 2
}

TEST_P(Ply, VerticesHaveNormalsColorsAndTextureCoordinates) {
  std::string text =
      start() + "element vertex 3\n" + kPosition +
      "property float nx\nproperty float ny\nproperty float nz\nproperty uchar red\nproperty uchar green\n"
      "property uchar blue\nproperty float texture_u\nproperty float texture_v\n"
      "element extra 2\nproperty list uchar short numbers\n"
      "element face 1\nproperty list int uint vertex_index\nend_header\n";
  for (int i = 0; i < 3; ++i)
    text += values<float>({float(i == 1), float(i == 2)}) + values<double>({0}) + values<float>({0, 0, 2}) +
            values<uint8_t>({255, 188, 0}) + values<float>({0.25f, 0.125f});
  text += values<uint8_t>({2}) + values<int16_t>({-1, 7}) + values<uint8_t>({0});
  text += values<int32_t>({3}) + values<uint32_t>({0, 1, 2});
  const Scene scene = MeshFile("a.ply", text).load();
  const Mesh& mesh = scene.meshes.at(0);
  ASSERT_EQ(mesh.positions.size(), 3u);
  EXPECT_EQ(mesh.attributes[2].normal, vec3(0, 0, 1));
  EXPECT_EQ(mesh.attributes[2].uv0, vec2(0.25f, 0.875f));
  ASSERT_EQ(mesh.extras.size(), 3u);
  EXPECT_NEAR(mesh.extras[0].color.g, 0.50289, 1e-4);  // IEC 61966-2-1: ((188/255 + 0.055) / 1.055)^2.4
  EXPECT_EQ(mesh.extras[0].color.r, 1);
  EXPECT_EQ(mesh.extras[0].color.b, 0);
  EXPECT_EQ(vec3(scene.materials[0].data.baseColor), vec3(1));
}

// The coordinates of a face's corners: u grows along y.
TEST_P(Ply, TangentsAreMadeOnRequest) {
  std::string text = start() + "element vertex 3\n" + kPosition +
                     "element face 1\nproperty list uchar int vertex_indices\n"
                     "property list uchar float texcoord\nend_header\n";
  for (int i = 0; i < 3; ++i) text += values<float>({float(i == 1), float(i == 2)}) + values<double>({0});
  text += values<uint8_t>({3}) + values<int32_t>({0, 1, 2}) + values<uint8_t>({6}) + values<float>({0, 0, 0, 1, 1, 0});
  const MeshFile file("a.ply", text);
  EXPECT_EQ(file.load().meshes.at(0).attributes[0].tangent, vec4(0));
  EXPECT_EQ(file.load({.tangents = true}).meshes.at(0).attributes[0].tangent, vec4(0, 1, 0, -1));
}

TEST_P(Ply, PointsAreSpheresOfTheGivenRadius) {
  const std::string text = start() + "element vertex 2\n" + kPosition + "end_header\n" + values<float>({1, 2}) +
                           values<double>({3}) + values<float>({-1, 2}) + values<double>({3});
  const MeshFile file("a.ply", text);
  EXPECT_THAT(file.error(), HasSubstr("--point-radius"));
  const Scene scene = file.load({.unit = "cm", .pointRadius = 0.001f});
  EXPECT_EQ(scene.triangleCount(), 40u);
  const std::vector<dvec3> corners = cornersOf(scene);
  for (size_t i = 0; i < corners.size(); i += 3) {
    const dvec3 center(i < 60 ? 0.01 : -0.01, 0.02, 0.03);
    EXPECT_NEAR(glm::length(corners[i] - center), 0.001, 1e-8);
    const dvec3 normal = glm::cross(corners[i + 1] - corners[i], corners[i + 2] - corners[i]);
    EXPECT_GT(glm::dot(normal, corners[i] - center), 0);
  }
  EXPECT_THAT(file.error(ExitCode::Usage, {.pointRadius = 0.0f}), HasSubstr("--point-radius"));
}

// The format allows elements in any order. Quadrilaterals have no fixed number of bytes.
TEST_P(Ply, FacesMayPrecedeVertices) {
  const std::string header =
      start() +
      "element note 1\nproperty int number\nelement face 2\nproperty list uchar int vertex_indices\n"
      "element vertex 4\n" +
      kPosition + "element tristrips 1\nproperty list int int vertex_indices\nend_header\n";
  std::string text = header + values<int32_t>({7}) + values<uint8_t>({4}) + values<int32_t>({0, 1, 2, 3}) +
                     values<uint8_t>({3}) + values<int32_t>({0, 2, 3});
  for (const vec2& p : {vec2(0, 0), vec2(1, 0), vec2(1, 2), vec2(0, 2)})
    text += values<float>({p.x, p.y}) + values<double>({5});
  text += values<int32_t>({3, 0, 1, 2});
  const Scene scene = MeshFile("a.ply", text).load();
  EXPECT_EQ(scene.triangleCount(), 4u);
  double area = 0;
  const std::vector<dvec3> corners = cornersOf(scene);
  for (size_t i = 0; i < corners.size(); i += 3) {
    EXPECT_EQ(corners[i].z, 5);
    area += glm::cross(corners[i + 1] - corners[i], corners[i + 2] - corners[i]).z / 2;
  }
  EXPECT_EQ(area, 2 + 1 + 1);  // the quadrilateral, half of it, and half of it
}

TEST_P(Ply, FacesOfTwoCornersAreReported) {
  std::string text = start() + "element vertex 2\n" + kPosition +
                     "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  for (const float x : {0.f, 1.f}) text += values<float>({x, 0}) + values<double>({0});
  const MeshFile file("a.ply", text + values<uint8_t>({2}) + values<int32_t>({0, 1}));
  EXPECT_THAT(file.error(), HasSubstr("none of its 1 faces has at least 3 corners"));
  EXPECT_EQ(file.load({.pointRadius = 0.1f}).triangleCount(), 40u);
}

TEST(PointRadius, IsForFilesWithoutFaces) {
  const std::string triangle =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string positions = "0 0 0\n1 0 0\n0 1 0\n";
  const std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const std::string stl = "solid a\nfacet normal 0 0 1\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendfacet\nendsolid\n";
  const auto warningsOf = [](const std::string& name, const std::string& text) {
    std::vector<std::string> warnings;
    const WarningCapture capture(warnings);
    MeshFile(name, text).load({.pointRadius = 0.1f});
    return warnings;
  };
  EXPECT_THAT(warningsOf("a.ply", triangle + "end_header\n" + positions), testing::IsEmpty());
  const auto unused = testing::ElementsAre(HasSubstr("has faces, so --point-radius has no effect"));
  EXPECT_THAT(warningsOf("a.ply", triangle + "element face 1\nproperty list uchar int vertex_indices\nend_header\n" +
                                      positions + "3 0 1 2\n"),
              unused);
  EXPECT_THAT(warningsOf("a.obj", obj), unused);
  EXPECT_THAT(warningsOf("a.stl", stl), unused);
}

TEST_P(Ply, StripsAlternate) {
  std::string text = start() + "element vertex 5\n" + kPosition +
                     "element tristrips 1\nproperty list int int vertex_indices\nend_header\n";
  for (int i = 0; i < 5; ++i) text += values<float>({float(i / 2), float(i % 2)}) + values<double>({0});
  text += values<int32_t>({8}) + values<int32_t>({0, 2, 1, 3, -1, 2, 4, 3});
  const std::vector<dvec3> corners = cornersOf(MeshFile("a.ply", text).load());
  ASSERT_EQ(corners.size(), 9u);
  for (size_t i = 0; i < 9; i += 3)
    EXPECT_GT(glm::cross(corners[i + 1] - corners[i], corners[i + 2] - corners[i]).z, 0) << i;
}

TEST_P(Ply, ShortFilesAreReported) {
  const std::string text = start() + "element vertex 1000000000\n" + kPosition + "end_header\n" + values<float>({1, 2});
  EXPECT_THAT(MeshFile("a.ply", text).error(), HasSubstr("1000000000 rows"));
  const std::string list = start() + "element vertex 1\n" + kPosition +
                           "element face 1\nproperty list int int vertex_indices\nend_header\n" +
                           values<float>({1, 2}) + values<double>({3}) + values<int32_t>({2'000'000'000}) +
                           values<int32_t>({0, 0, 0});
  EXPECT_THAT(MeshFile("a.ply", list).error(), HasSubstr("ends in row 1"));
}

// A strip of squares along X, of which each is two triangles with a byte before and a float after its corners; more
// rows than one thread reads.
struct Grid {
  static constexpr uint32_t kColumns = 20001, kFaces = 2 * (kColumns - 1);
  std::vector<std::array<uint32_t, 3>> faces;
  Grid() {
    for (uint32_t i = 0; i + 1 < kColumns; ++i) {
      faces.push_back({2 * i, 2 * i + 2, 2 * i + 3});
      faces.push_back({2 * i, 2 * i + 3, 2 * i + 1});
    }
  }
};

class PlyGrid : public Ply {
 protected:
  std::string file(const Grid& grid) const {
    std::string text = start() + fmt::format("element vertex {}\n", 2 * Grid::kColumns) + kPosition +
                       "property float nx\nproperty float ny\nproperty float nz\n" +
                       fmt::format("element face {}\n", grid.faces.size()) +
                       "property uchar flag\nproperty list uchar int vertex_indices\nproperty float quality\n"
                       "element extra 1\nproperty int number\nend_header\n";
    for (uint32_t i = 0; i < 2 * Grid::kColumns; ++i) {
      text += values<float>({float(i / 2), float(i % 2)}) + values<double>({0.5}) + values<float>({0, 0, 2});
    }
    for (const auto& face : grid.faces)
      text +=
          values<uint8_t>({7, 3}) + values<int32_t>({int(face[0]), int(face[1]), int(face[2])}) + values<float>({9});
    return text + values<int32_t>({5});
  }
};
INSTANTIATE_TEST_SUITE_P(Encodings, PlyGrid,
                         testing::Values(Encoding{"ascii", true, false}, Encoding{"binary_little_endian", false, false},
                                         Encoding{"binary_big_endian", false, true}),
                         [](const auto& info) { return std::string(info.param.format); });

TEST_P(PlyGrid, TrianglesAreReadOnAllThreads) {
  const Grid grid;
  const Scene scene = MeshFile("a.ply", file(grid)).load();
  ASSERT_EQ(scene.meshes.size(), 1u);
  const Mesh& mesh = scene.meshes[0];
  ASSERT_EQ(mesh.indices.size(), size_t{3} * Grid::kFaces);
  for (size_t i = 0; i < mesh.indices.size(); ++i) ASSERT_EQ(mesh.indices[i], grid.faces[i / 3][i % 3]) << i;
  ASSERT_EQ(mesh.positions.size(), size_t{2} * Grid::kColumns);
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    ASSERT_EQ(mesh.positions[i], vec3(float(i / 2), float(i % 2), 0.5f)) << i;
    ASSERT_EQ(mesh.attributes[i].normal, vec3(0, 0, 1)) << i;
  }
  EXPECT_EQ(mesh.boundsMin, vec3(0, 0, 0.5f));
  EXPECT_EQ(mesh.boundsMax, vec3(float(Grid::kColumns - 1), 1, 0.5f));
  EXPECT_FLOAT_EQ(mesh.longestEdge, std::sqrt(2.0f));
}

// Rows of text need not be lines: they may be split, share a line, and be separated by blank lines.
TEST(PlyLines, AreNotRows) {
  constexpr uint32_t kColumns = 20001;
  const auto file = [](bool isIrregular) {
    std::string text = "ply\nformat ascii 1.0\n" + fmt::format("element vertex {}\n", 2 * kColumns) + kPosition +
                       fmt::format("element face {}\n", 2 * (kColumns - 1)) +
                       "property list uchar int vertex_indices\nend_header\n";
    for (uint32_t i = 0; i < 2 * kColumns; ++i)
      text += fmt::format("{} {}{}0.5{}\n", i / 2, i % 2, isIrregular && i == 30000 ? "\n" : " ", i == 7 ? " " : "");
    for (uint32_t i = 0; i + 1 < kColumns; ++i)
      text += fmt::format("3 {} {} {}{}3 {} {} {}{}\n", 2 * i, 2 * i + 2, 2 * i + 3, isIrregular && i == 9 ? " " : "\n",
                          2 * i, 2 * i + 3, 2 * i + 1, isIrregular && i == 20 ? "\n\n" : "");
    return text.substr(0, text.size() - 1);  // the last line has no end
  };
  const Scene lines = MeshFile("a.ply", file(false)).load(), other = MeshFile("a.ply", file(true)).load();
  ASSERT_EQ(lines.meshes[0].indices.size(), size_t{6} * (kColumns - 1));
  EXPECT_EQ(lines.meshes[0].positions, other.meshes[0].positions);
  EXPECT_EQ(lines.meshes[0].indices, other.meshes[0].indices);
  EXPECT_EQ(cornersOf(lines)[6 * 12345 + 2], dvec3(12346, 1, 0.5));
}

TEST_P(PlyGrid, InvalidCornersAreReportedByFace) {
  for (const uint32_t wrong : {2 * Grid::kColumns, ~0u}) {
    Grid grid;
    grid.faces[30000][1] = wrong;
    EXPECT_THAT(MeshFile("a.ply", file(grid)).error(),
                HasSubstr(fmt::format("face 30001 refers to vertex {}, but", int(wrong))));
  }
}

std::string textured(const std::string& names) {
  return "ply\nformat ascii 1.0\n" + names +
         "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 2\n"
         "property list uchar int vertex_indices\nproperty list uchar float texcoord\nproperty int texnumber\n"
         "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 6 0 0 1 0 0 1 1\n3 0 1 2 6 0 0 0.5 0 0 0.5 0\n";
}

TEST(PlyTextures, BelongToFaces) {
  const std::string image = png(1, 1, {{0, 255, 0, 255}});
  MeshFile file("a.ply", textured("comment TextureFile one.png\ncomment TextureFile sub/two.png\n"));
  file.add("one.png", image).add("sub/two.png", image);
  const Scene scene = file.load();
  ASSERT_EQ(scene.instances.size(), 2u);
  ASSERT_EQ(scene.textures.size(), 2u);
  EXPECT_EQ(scene.textures[0].width, 1u);
  EXPECT_EQ(scene.materials[0].slots[shared::kTextureBaseColor].texture, 0);
  EXPECT_EQ(scene.meshes[scene.instances[0].mesh].attributes[1].uv0, vec2(0.5f, 1));  // texture 0: the second face
  EXPECT_EQ(scene.meshes[scene.instances[1].mesh].attributes[1].uv0, vec2(1, 1));
  EXPECT_EQ(scene.instances[0].id, scene.instances[1].id);
  EXPECT_NE(scene.instances[0].part, scene.instances[1].part);
  EXPECT_EQ(scene.files.size(), 3u);
}

// Triangles of an element without colors, coordinates or numbers of textures are white and have coordinates of 0.
TEST(PlyFaces, OfSeveralElementsMayHaveOtherProperties) {
  const std::string start = std::string("ply\nformat ascii 1.0\nelement vertex 4\n") + kPosition;
  const std::string plain = "element face 1\nproperty list uchar int vertex_indices\n",
                    strips = "element tristrips 1\nproperty list int int vertex_indices\n";
  const std::string full = plain +
                           "property list uchar float texcoord\nproperty float red\nproperty float green\n"
                           "property float blue\n";
  const std::string vertices = "end_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n", triangle = "3 0 1 2\n",
                    strip = "4 1 2 0 3\n", rich = "3 0 2 3 6 0.5 0.5 1 1 0 1 0 1 0\n";
  for (const std::string& text : {plain + full + vertices + triangle + rich, full + plain + vertices + rich + triangle,
                                  full + strips + vertices + rich + strip}) {
    const Scene scene = MeshFile("a.ply", start + text).load();
    const Mesh& mesh = scene.meshes[scene.instances[0].mesh];
    int green = 0;
    for (const uint32_t vertex : mesh.indices) {
      const bool isGreen = mesh.extras[vertex].color == vec4(0, 1, 0, 1);
      green += isGreen;
      EXPECT_EQ(mesh.extras[vertex].color.r, isGreen ? 0 : 1);
      if (!isGreen) {
        EXPECT_EQ(mesh.attributes[vertex].uv0, vec2(0, 0));
      }
    }
    EXPECT_EQ(green, 3);
    EXPECT_EQ(mesh.indices.size(), text.find("tristrips") == text.npos ? 6u : 9u);
  }
}

TEST(PlyTextures, StayInTheirFolder) {
  MeshFile file("in/a.ply", textured("comment TextureFile ../secret.png\n"));
  file.add("secret.png", png(1, 1, {{0, 0, 0, 255}}));
  EXPECT_THAT(file.error(), HasSubstr("outside the scene's folder"));
  EXPECT_EQ(MeshFile("a.ply", textured("comment TextureFile missing.png\n")).load().textures.size(), 0u);
}

TEST(PlyErrors, NameTheLine) {
  const auto error = [](const std::string& text) { return MeshFile("a.ply", text).error(); };
  EXPECT_THAT(error("plyy\n"), HasSubstr("\"ply\""));
  EXPECT_THAT(error("ply\nformat ascii 1.0\n"), HasSubstr("end_header"));
  EXPECT_THAT(error("ply\nformat zip 1.0\nend_header\n"), HasSubstr("line 2 "));
  EXPECT_THAT(error("ply\nelement vertex 1\nproperty quad x\nend_header\n"), HasSubstr("line 3 "));
  EXPECT_THAT(error("ply\nformat ascii 1.0\nby hand\nend_header\n"), HasSubstr("no vertices"));
  EXPECT_THAT(error("ply\nformat ascii 1.0\nelement vertex 1\nproperty float a\nend_header\n1\n"),
              HasSubstr("x, y and z"));
  EXPECT_THAT(error("ply\nformat ascii 1.0\nelement vertex 99\nend_header\n"), HasSubstr("no properties"));
  const std::string start = std::string("ply\nformat ascii 1.0\nelement vertex 1\n") + kPosition +
                            "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  EXPECT_THAT(error(start + "0 0 zero\n3 0 0 0\n"), HasSubstr("line 10 has \"zero\""));
  EXPECT_THAT(error(start + "0 0 0\n3 0 0 1\n"), HasSubstr("face 1 refers to vertex 1"));
  const std::string facesFirst = std::string(
                                     "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\n"
                                     "element vertex 1\n") +
                                 kPosition + "end_header\n";
  EXPECT_THAT(error(facesFirst + "3 0 0 1\n0 0 0\n"), HasSubstr("face 1 refers to vertex 1, but there are 1 vertices"));
  EXPECT_THAT(error(facesFirst + "3 0 0 0\n"), HasSubstr("\"vertex\" should have 1 rows"));
  EXPECT_THAT(error(start + "0 0 0\n3 0 0 -1\n"), HasSubstr("face 1 refers to vertex -1"));
  EXPECT_THAT(error(start + "0 0 0\n-3 0 0 0\n"), HasSubstr("list of -3"));
  EXPECT_THAT(error(std::string("ply\nformat ascii 1.0\nelement vertex 3\n") + kPosition +
                    "element face 1\nproperty list uchar int vertex_indices\nelement vertex 1\n" + kPosition +
                    "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n0 0 0\n"),
              HasSubstr("more than one element \"vertex\""));
}

}  // namespace
}  // namespace latelight::scene::test
