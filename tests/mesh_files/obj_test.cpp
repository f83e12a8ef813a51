// OBJ files: faces, indices, nodes, normals, and the materials of MTL.
#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "base/log.h"
#include "mesh_files/support.h"

namespace latelight::scene::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr const char* kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

std::vector<std::string> pathsOf(const Scene& scene) {
  std::vector<std::string> paths;
  for (const Instance& instance : scene.instances) paths.push_back(scene.nodes[instance.node].path);
  return paths;
}

const Material& materialOf(const Scene& scene, size_t instance = 0) {
  return scene.materials[scene.instances.at(instance).material];
}

TEST(Obj, PolygonsNegativeIndicesAndContinuedLines) {
  const std::vector<std::string> faces = {"f 1 2 3 4\n",
                                          "f -4 -3 -2 -1\n",
                                          "f 1 2 \\\n 3 \\\r\n 4\n",
                                          "f 1// 2// 3// 4//\n",
                                          "  f\t1 2 3 4  # a comment\r\n",
                                          "fo 1 2 3 4"};
  for (const std::string& face : faces) {
    const Scene scene = MeshFile("a.obj", kSquare + face).load();
    EXPECT_TRUE(scene.yUp);
    const std::vector<dvec3> corners = cornersOf(scene);
    ASSERT_EQ(corners.size(), 6u) << face;
    double area = 0;
    for (size_t i = 0; i < 6; i += 3)
      area += glm::cross(corners[i + 1] - corners[i], corners[i + 2] - corners[i]).z / 2;
    EXPECT_NEAR(area, 1, 1e-9) << face;
  }
}

// Returns an OBJ file with one face of these corners, which lie in a plane that no axis is normal to.
std::string objOfPolygon(const std::vector<glm::dvec2>& corners) {
  std::string vertices, face = "f";
  for (size_t i = 0; i < corners.size(); ++i) {
    const auto& [x, y] = std::pair(corners[i].x, corners[i].y);
    vertices += fmt::format("v {} {} {}\n", 0.8 * x - 0.36 * y, 0.8 * y, 0.6 * x + 0.48 * y);
    face += fmt::format(" {}", i + 1);
  }
  return vertices + face + "\n";
}

// Twice the area of the polygon by the shoelace formula, negative for clockwise corners.
double doubleArea(const std::vector<glm::dvec2>& p) {
  double sum = 0;
  for (size_t i = 0; i < p.size(); ++i) {
    const glm::dvec2 a = p[i], b = p[(i + 1) % p.size()];
    sum += a.x * b.y - a.y * b.x;
  }
  return sum;
}

// The triangles do not overlap if their areas add up to that of the polygon.
TEST(Obj, ConcavePolygonsMayHaveManyCorners) {
  constexpr double kTurn = 2 * std::numbers::pi;
  std::map<std::string, std::vector<glm::dvec2>> polygons;
  for (const int count : {300, 1000, 100'000})  // waves around a circle
    for (int i = 0; i < count; ++i) {
      const double angle = kTurn * i / count, radius = 1 + 0.3 * std::sin(10 * angle);
      polygons[fmt::format("wave {}", count)].emplace_back(radius * std::cos(angle), radius * std::sin(angle));
    }
  std::minstd_rand random(1);
  for (int i = 0; i < 20'000; ++i) {
    const double angle = kTurn * i / 20'000, radius = 0.2 + 0.8 * random() / std::minstd_rand::max();
    polygons["star"].emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  }
  for (int i = 0; i < 1000; ++i) {  // a spiral with a wall of constant thickness
    const double angle = 5 * kTurn * i / 1000;
    polygons["spiral"].emplace_back((2 + angle) * std::cos(angle), (2 + angle) * std::sin(angle));
  }
  for (int i = 999; i >= 0; --i) {
    const double angle = 5 * kTurn * i / 1000;
    polygons["spiral"].emplace_back((5 + angle) * std::cos(angle), (5 + angle) * std::sin(angle));
  }
  for (int i = 0; i <= 400; ++i)  // a ring, which a cut makes one polygon
    polygons["ring"].emplace_back(2 * std::cos(kTurn * (i % 400) / 400), 2 * std::sin(kTurn * (i % 400) / 400));
  for (int i = 400; i >= 0; --i)
    polygons["ring"].emplace_back(std::cos(kTurn * (i % 400) / 400), std::sin(kTurn * (i % 400) / 400));
  for (const auto& [name, polygon] : polygons) {
    const std::vector<dvec3> corners = cornersOf(MeshFile("a.obj", objOfPolygon(polygon)).load());
    ASSERT_EQ(corners.size(), 3 * (polygon.size() - 2)) << name;
    double sum = 0;
    for (size_t i = 0; i < corners.size(); i += 3)
      sum += glm::length(glm::cross(corners[i + 1] - corners[i], corners[i + 2] - corners[i]));
    EXPECT_NEAR(sum / std::abs(doubleArea(polygon)), 1, 1e-5) << name;
  }
}

// Blocks of the file are parsed separately; an index may refer to any of them.
TEST(Obj, IndicesCrossBlocks) {
  std::string text;
  for (int i = 0; i < 200'000; ++i)
    text += fmt::format("v {} 0 0\nv {} 1 0\nv {} 0 1\n# a long comment\nf -3 -2 -1\n", i, i, i);
  text += "f 1 300000 -1\n";
  ASSERT_GT(text.size(), size_t{9} << 20);  // several blocks of 4 MiB
  const std::vector<dvec3> corners = cornersOf(MeshFile("a.obj", text).load());
  ASSERT_EQ(corners.size(), 600'003u);
  for (size_t i = 0; i < 600'000; i += 9999)
    EXPECT_EQ(corners[i], dvec3(double(i / 3), double(i % 3 == 1), double(i % 3 == 2)));
  EXPECT_EQ(corners[600'000], dvec3(0, 0, 0));
  EXPECT_EQ(corners[600'001], dvec3(99999, 0, 1));
  EXPECT_EQ(corners[600'002], dvec3(199999, 0, 1));
}

TEST(Obj, ObjectsAndGroupsAreNodes) {
  const std::string text = std::string(kSquare) +
                           "f 1 2 3\ng left side\nf 1 2 4\no body\nf 2 3 4\ng arm\nf 1 3 4\nusemtl red\nf 4 3 2\n"
                           "o empty\no body\nf 1 4 2\n";
  const Scene scene = MeshFile("robot.obj", text).load();
  EXPECT_THAT(pathsOf(scene), ElementsAre("/robot", "/robot/left side", "/robot/body", "/robot/body", "/robot/body/arm",
                                          "/robot/body/arm"));
  EXPECT_EQ(scene.nodes.size(), 4u);
  EXPECT_EQ(scene.instances[4].id, scene.instances[5].id);
  EXPECT_NE(scene.instances[4].part, scene.instances[5].part);
}

// Old files are in Latin-1. A library in UTF-8 defines the material of a file in Latin-1. Names of image files keep
// their bytes, because those are the names in the file system.
TEST(Obj, NamesAreUtf8) {
  MeshFile file(
      "Stra\xdf"
      "e.obj",
      std::string("mtllib a.mtl\n") + kSquare +
          "vt 0 0\no B\xe6k\nusemtl f\xf8\nf 1 2 3\ng S\xf8\nusemtl gr\xfcn\nf 1/1 2/1 3/1\ng \xc3\xbc\nf 1 2 4\n");
  file.add("a.mtl", "newmtl f\xc3\xb8\nKd 1 0 0\nnewmtl gr\xfcn\nmap_Kd gr\xfcn.png\n");
  file.add("gr\xfcn.png", png(1, 1, {{0, 255, 0, 255}}));
  const Scene scene = file.load();
  EXPECT_THAT(pathsOf(scene), ElementsAre("/Straße/Bæk", "/Straße/Bæk/Sø", "/Straße/Bæk/ü"));
  EXPECT_EQ(materialOf(scene).name, "fø");
  EXPECT_EQ(materialOf(scene).data.baseColor, vec4(1, 0, 0, 1));
  EXPECT_EQ(materialOf(scene, 1).name, "grün");
  ASSERT_EQ(scene.textures.size(), 1u);
  EXPECT_EQ(scene.textures[0].name, "grün.png");
}

TEST(Obj, CornersShareVertices) {
  const std::string text =
      std::string(kSquare) + "vt 0 0\nvt 1 0.25\nvn 0 0 2\nf 1/1/1 2/2/1 3/2/1\nf 1/1/1 3/2/1 4/1/1\n";
  const Mesh mesh = MeshFile("a.obj", text).load().meshes.at(0);
  ASSERT_EQ(mesh.positions.size(), 4u);
  EXPECT_EQ(mesh.attributes[0].normal, vec3(0, 0, 1));
  EXPECT_EQ(mesh.attributes[0].uv0, vec2(0, 1));
  EXPECT_EQ(mesh.attributes[1].uv0, vec2(1, 0.75f));
}

// A roof of two squares that meet at a right angle, along the y axis.
TEST(Obj, SmoothingGroupsAverageNormals) {
  const std::string roof = "v 0 0 0\nv 0 1 0\nv 1 1 -1\nv 1 0 -1\nv -1 1 -1\nv -1 0 -1\n";
  const auto normalAtRidge = [&](const std::string& faces) {
    return MeshFile("a.obj", roof + faces).load().meshes.at(0).attributes[0].normal;
  };
  const float s = std::sqrt(0.5f);
  const auto expectNormal = [](vec3 a, vec3 b) { EXPECT_LT(glm::length(a - b), 1e-6f); };
  expectNormal(normalAtRidge("f 1 4 3 2\nf 1 2 5 6\n"), {s, 0, s});
  expectNormal(normalAtRidge("s 1\nf 1 4 3 2\nf 1 2 5 6\n"), {0, 0, 1});
  expectNormal(normalAtRidge("s 1\nf 1 4 3 2\ns 2\nf 1 2 5 6\n"), {s, 0, s});
  expectNormal(normalAtRidge("s 1\nf 1 4 3 2\ns off\nf 1 2 5 6\n"), {s, 0, s});
  // Smoothing continues across materials.
  expectNormal(normalAtRidge("s 3\nf 1 4 3 2\nusemtl b\nf 1 2 5 6\n"), {0, 0, 1});
}

TEST(Obj, VerticesHaveColors) {
  const Scene scene = MeshFile("a.obj", "v 0 0 0 1 0.5 0\nv 1 0 0 1 0.5 0\nv 0 1 0\nf 1 2 3\n").load();
  ASSERT_EQ(scene.meshes.at(0).extras.size(), 3u);
  EXPECT_NEAR(scene.meshes[0].extras[0].color.g, 0.21404, 1e-4);
  EXPECT_EQ(scene.meshes[0].extras[2].color, vec4(1));
}

// --- materials ------------------------------------------------------------------------------------------------------

MeshFile withMtl(const std::string& mtl) {
  MeshFile file("a.obj",
                std::string("mtllib a b.mtl\nvt 0 0\nvt 1 0\nvt 1 1\n") + kSquare + "usemtl m\nf 1/1 2/2 3/3\n");
  file.add("a b.mtl", "newmtl m\n" + mtl);
  return file;
}

TEST(Mtl, PhongBecomesRoughness) {
  const Scene scene = withMtl("Kd 0.25 0.5 1\nKs 0.5 0.25 0\nNs 30\nd 0.5\nKe 1 2 3\n").load();
  const shared::Material& m = materialOf(scene).data;
  EXPECT_EQ(materialOf(scene).name, "m");
  EXPECT_EQ(m.baseColor, vec4(0.25f, 0.5f, 1, 0.5f));
  EXPECT_NEAR(m.roughness, 0.5, 1e-6);  // (2 / 32)^(1/4)
  EXPECT_EQ(m.specularColor, vec3(1, 0.5f, 0));
  EXPECT_EQ(m.emissive, vec3(1, 2, 3));
  EXPECT_EQ(m.metallic, 0);
  EXPECT_EQ(m.flags & shared::kMaterialBlended, shared::kMaterialBlended);
  EXPECT_EQ(materialOf(withMtl("Tr 0.25\n").load()).data.baseColor.a, 0.75f);
  EXPECT_EQ(materialOf(withMtl("Kd 1 0 0\nillum 0\n").load()).data.flags, shared::kMaterialUnlit);
  EXPECT_EQ(materialOf(withMtl("illum 1\nKs 1 1 1\nNs 900\n").load()).data.roughness, 1);
}

TEST(Mtl, PbrKeysAreUsed) {
  const shared::Material m =
      materialOf(withMtl("Pr 0.3\nPm 0.7\nPs 0.2\nPc 0.9\nPcr 0.1\naniso 0.4\nanisor 0.25\nNs 900\n").load()).data;
  EXPECT_EQ(m.roughness, 0.3f);
  EXPECT_EQ(m.metallic, 0.7f);
  EXPECT_EQ(m.layers.sheenColor, vec3(0.2f));
  EXPECT_EQ(m.layers.clearcoat, 0.9f);
  EXPECT_EQ(m.layers.clearcoatRoughness, 0.1f);
  EXPECT_EQ(m.layers.anisotropy, 0.4f);
  EXPECT_NEAR(m.layers.anisotropyRotation, 1.5707963, 1e-6);
}

std::array<int, 4> texelOf(const Scene& scene, uint32_t slot, size_t at = 0) {
  const auto* texel =
      reinterpret_cast<const uint8_t*>(scene.textures.at(size_t(materialOf(scene).slots[slot].texture)).pixels.get()) +
      4 * at;
  return {texel[0], texel[1], texel[2], texel[3]};
}

TEST(Mtl, MapsBecomeTextures) {
  MeshFile file = withMtl(
      "map_Kd -s 2 4 1 -o 0.5 0.25 -clamp on my color.png\nmap_d mask.png\nmap_Pr -imfchan g rough.png\nmap_Pm "
      "rough.png\n"
      "norm -bm 0.5 normal.png\nmap_Ke -mm 0 2 color.png\n");
  file.add("my color.png", png(1, 1, {{10, 20, 30, 255}}))
      .add("mask.png", png(2, 1, {{40, 40, 40, 255}, {80, 80, 80, 255}}));
  file.add("rough.png", png(1, 1, {{200, 100, 200, 255}})).add("normal.png", png(1, 1, {{128, 128, 255, 255}}));
  file.add("color.png", png(1, 1, {{1, 2, 3, 255}}));
  const Scene scene = file.load();
  const Material& m = materialOf(scene);
  EXPECT_THAT(texelOf(scene, shared::kTextureBaseColor, 0), ElementsAre(10, 20, 30, 40));
  EXPECT_THAT(texelOf(scene, shared::kTextureBaseColor, 1), ElementsAre(10, 20, 30, 80));
  EXPECT_TRUE(scene.textures[size_t(m.slots[shared::kTextureBaseColor].texture)].srgb);
  // Luminance of (200, 100, 200): 128.48.
  EXPECT_THAT(texelOf(scene, shared::kTextureMetallicRoughness), ElementsAre(255, 100, 128, 255));
  EXPECT_FALSE(scene.textures[size_t(m.slots[shared::kTextureMetallicRoughness].texture)].srgb);
  EXPECT_THAT(texelOf(scene, shared::kTextureNormal), ElementsAre(128, 128, 255, 255));
  EXPECT_EQ(m.data.normalScale, 0.5f);
  EXPECT_EQ(m.data.emissive, vec3(2));
  EXPECT_EQ(m.data.roughness, 1);
  EXPECT_EQ(m.data.metallic, 1);
  EXPECT_EQ(m.slots[shared::kTextureBaseColor].sampler.wrapU, Wrap::Clamp);
  // (u, v) = (0.25, 0.5) with v up is mapped to (2 u + 0.5, 4 v + 0.25) = (1, 2.25), which is -1.25 with v down.
  const shared::TextureTransform& t = m.data.transforms[shared::kTextureBaseColor];
  EXPECT_NEAR(glm::dot(t.row0, vec3(0.25f, 0.5f, 1)), 1, 1e-6);
  EXPECT_NEAR(glm::dot(t.row1, vec3(0.25f, 0.5f, 1)), -1.25, 1e-6);
  EXPECT_NE(scene.meshes[0].attributes[0].tangent, vec4(0));
}

// Roughness and metalness are one texture, as color and alpha are, which has one transform.
TEST(Mtl, DifferentOptionsOfMapsThatAreCombinedAreReported) {
  const auto warningsOf = [](const std::string& statements) {
    std::vector<std::string> warnings;
    const WarningCapture capture(warnings);
    MeshFile file = withMtl(statements);
    file.add("a.png", png(1, 1, {{10, 20, 30, 255}})).add("b.png", png(1, 1, {{10, 20, 30, 255}}));
    file.load();
    return warnings;
  };
  for (const char* options : {"-s 2 2 1", "-o 0.5 0 0", "-clamp on"}) {
    const std::string with = fmt::format("{} b.png\n", options);
    EXPECT_THAT(warningsOf("map_Pr a.png\nmap_Pm " + with), ElementsAre(HasSubstr("those of map_Pr are used")));
    EXPECT_THAT(warningsOf("map_Kd a.png\nmap_d " + with), ElementsAre(HasSubstr("those of map_Kd are used")));
    EXPECT_THAT(warningsOf("map_Pr " + with + "map_Pm " + with), testing::IsEmpty());
    EXPECT_THAT(warningsOf("map_Pm " + with), testing::IsEmpty());
  }
}

TEST(Mtl, TangentsFollowTheScaleOfNormalMaps) {
  MeshFile file = withMtl("norm -s -1 1 normals.png\n");
  file.add("normals.png", png(1, 1, {{128, 128, 255, 255}}));
  EXPECT_EQ(file.load().meshes.at(0).attributes[0].tangent, vec4(-1, 0, 0, -1));
}

TEST(Mtl, TangentsAreMadeOnRequest) {
  const MeshFile file = withMtl("Kd 1 0 0\n");
  EXPECT_EQ(file.load().meshes.at(0).attributes[0].tangent, vec4(0));
  EXPECT_EQ(file.load({.tangents = true}).meshes.at(0).attributes[0].tangent, vec4(1, 0, 0, 1));
}

TEST(Mtl, HeightMapsBecomeNormalMaps) {
  MeshFile file = withMtl("map_Bump -bm 1 height.png\n");
  // A ramp along u, with 51 of 255 per texel, that wraps.
  file.add(
      "height.png",
      png(5, 1, {{0, 0, 0, 255}, {51, 51, 51, 255}, {102, 102, 102, 255}, {153, 153, 153, 255}, {204, 204, 204, 255}}));
  const Scene scene = file.load();
  const double slope = 8 * 0.2;  // 8 texels between black and white
  const double length = std::hypot(slope, 1);
  const auto texel = texelOf(scene, shared::kTextureNormal, 2);
  EXPECT_NEAR(texel[0], (-slope / length * 0.5 + 0.5) * 255, 0.51);
  EXPECT_NEAR(texel[1], 127.5, 0.51);
  EXPECT_NEAR(texel[2], (1 / length * 0.5 + 0.5) * 255, 0.51);
  MeshFile normals = withMtl("bump normal.png\n");
  normals.add("normal.png", png(1, 1, {{200, 90, 250, 255}}));
  EXPECT_THAT(texelOf(normals.load(), shared::kTextureNormal), ElementsAre(200, 90, 250, 255));
}

// As glTF's scale: x and y of the normal are multiplied, and the result is normalized.
TEST(Mtl, BumpScalesNormalMaps) {
  const glm::dvec3 normal = glm::dvec3(200, 90, 220) / 127.5 - 1.0;
  for (const double scale : {0.0, 0.5, 3.0, -1.0}) {
    MeshFile file = withMtl(fmt::format("map_Bump -bm {} normal.png\n", scale));
    file.add("normal.png", png(1, 1, {{200, 90, 220, 255}}));
    const auto texel = texelOf(file.load(), shared::kTextureNormal);
    const glm::dvec3 expected = glm::normalize(normal * glm::dvec3(scale, scale, 1));
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(texel[size_t(i)], (expected[i] * 0.5 + 0.5) * 255, 0.51) << scale;
  }
}

// Programs write an opaque gray image, or the color image with its alpha. -imfchan states the channel.
TEST(Mtl, OpacityIsAlphaUnlessItIsOpaque) {
  const auto alphas = [](const std::string& statement, const std::vector<std::array<uint8_t, 4>>& texels) {
    MeshFile file = withMtl(statement);
    file.add("leaf.png", png(2, 1, texels));
    const Scene scene = file.load();
    return std::array{texelOf(scene, shared::kTextureBaseColor, 0)[3], texelOf(scene, shared::kTextureBaseColor, 1)[3]};
  };
  const std::vector<std::array<uint8_t, 4>> leaf = {{40, 40, 40, 255}, {80, 80, 80, 10}};
  const std::vector<std::array<uint8_t, 4>> mask = {{40, 40, 40, 255}, {80, 80, 80, 255}};
  EXPECT_THAT(alphas("map_Kd leaf.png\nmap_d leaf.png\n", leaf), ElementsAre(255, 10));
  EXPECT_THAT(alphas("map_d leaf.png\n", leaf), ElementsAre(255, 10));
  EXPECT_THAT(alphas("map_d leaf.png\n", mask), ElementsAre(40, 80));
  EXPECT_THAT(alphas("map_d -imfchan l leaf.png\n", leaf), ElementsAre(40, 80));
  EXPECT_THAT(alphas("map_d -imfchan m leaf.png\n", mask), ElementsAre(255, 255));
  EXPECT_THAT(alphas("map_d -mm 0 0.5 leaf.png\n", leaf), ElementsAre(128, 5));
}

TEST(Mtl, FilesOutsideAreRejected) {
  MeshFile file("in/a.obj", std::string("mtllib ../a.mtl\n") + kSquare + "f 1 2 3\n");
  file.add("a.mtl", "newmtl m\n");
  EXPECT_THAT(file.error(), HasSubstr("outside the scene's folder"));
  const std::filesystem::path outside = std::filesystem::path(file.path()).parent_path().parent_path();
  EXPECT_EQ(file.load({.allowOutside = {outside.string()}}).triangleCount(), 1u);
  MeshFile texture = withMtl("map_Kd /etc/passwd\n");
  EXPECT_THAT(texture.error(), HasSubstr("outside the scene's folder"));
}

// The names of images start from the library's folder, as in Blender, and from the OBJ file's if there is no such file.
TEST(Mtl, ImagesAreInTheLibrarysFolderFirst) {
  MeshFile file("a.obj", "mtllib \"my materials/m.mtl\"\nvt 0 0\nvt 1 0\nvt 1 1\n" + std::string(kSquare) +
                             "usemtl near\nf 1/1 2/2 3/3\nusemtl quoted\nf 1/1 2/2 4/3\nusemtl far\nf 1/1 3/2 4/3\n");
  file.add("my materials/m.mtl",
           "newmtl near\nmap_Kd wood.png\nnewmtl quoted\nmap_Kd \"red wood.png\"\nnewmtl far\nmap_Kd oak.png\n");
  file.add("my materials/wood.png", png(1, 1, {{1, 2, 3, 255}})).add("wood.png", png(1, 1, {{9, 9, 9, 255}}));
  file.add("my materials/red wood.png", png(1, 1, {{4, 5, 6, 255}})).add("oak.png", png(1, 1, {{7, 8, 9, 255}}));
  const Scene scene = file.load();
  ASSERT_EQ(scene.instances.size(), 3u);
  ASSERT_EQ(scene.textures.size(), 3u);
  const auto redOf = [&](size_t instance) {
    const int texture = materialOf(scene, instance).slots[shared::kTextureBaseColor].texture;
    return int(scene.textures.at(size_t(texture)).pixels[0]);
  };
  EXPECT_EQ(redOf(0), 1);
  EXPECT_EQ(redOf(1), 4);
  EXPECT_EQ(redOf(2), 7);
}

TEST(Mtl, MissingFilesAreLeftOut) {
  const Scene scene = withMtl("Kd 1 0 0\nmap_Kd C:\\images\\missing.png\n").load();
  EXPECT_EQ(vec3(materialOf(scene).data.baseColor), vec3(1, 0, 0));
  EXPECT_TRUE(scene.textures.empty());
  EXPECT_EQ(
      MeshFile("a.obj", std::string("mtllib no.mtl\n") + kSquare + "usemtl x\nf 1 2 3\n").load().materials[0].name,
      "x");
}

TEST(Obj, TextMayHaveAByteOrderMark) {
  EXPECT_EQ(MeshFile("a.obj", "\xef\xbb\xbfv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").load().triangleCount(), 1u);
  EXPECT_THAT(MeshFile("a.obj", "\xff\xfev").error(), HasSubstr("UTF-8"));
  MeshFile material("a.obj", std::string("mtllib a.mtl\n") + kSquare + "usemtl m\nf 1 2 3\n");
  material.add("a.mtl", "\xef\xbb\xbfnewmtl m\nKd 1 0 0\n");
  EXPECT_EQ(vec3(materialOf(material.load()).data.baseColor), vec3(1, 0, 0));
}

TEST(ObjErrors, LongPathsAreLimited) {
  std::string text = std::string(kSquare) + "o " + std::string(1 << 20, 'a') + "\n";
  for (int i = 0; i < 300; ++i) text += fmt::format("g {}\nf 1 2 3\n", i);
  EXPECT_THAT(MeshFile("a.obj", text).error(), HasSubstr("names of its objects and groups"));
}

TEST(ObjErrors, NameTheLine) {
  const auto error = [](const std::string& text) { return MeshFile("a.obj", kSquare + text).error(); };
  EXPECT_THAT(error(""), HasSubstr("no faces"));
  EXPECT_THAT(error("v 1 2\n"), HasSubstr("line 5 requires three numbers"));
  EXPECT_THAT(error("v 1 2 z\n"), HasSubstr("line 5 requires three numbers"));
  EXPECT_THAT(error("f 1 2\n"), HasSubstr("line 5 is a face of fewer than three corners"));
  EXPECT_THAT(error("f 1 2 5\n"), HasSubstr("line 5 refers to a vertex that does not exist: the file has 4"));
  EXPECT_THAT(error("# f\nf 1 2 3\nf -5 1 2\n"), HasSubstr("line 7 refers to a vertex"));
  EXPECT_THAT(error("f 0 1 2\n"), HasSubstr("counts from 1"));
  EXPECT_THAT(error("f 1 2 1000000000\n"), HasSubstr("line 5"));
  EXPECT_THAT(error("f 1 2 99999999999999999999\n"), HasSubstr("malformed"));
  EXPECT_THAT(error("f 1 2 a\n"), HasSubstr("malformed corner"));
  EXPECT_THAT(error("f 1/1/1/1 2 3\n"), HasSubstr("malformed corner"));
  EXPECT_THAT(error("v nan 0 0\nf 1 2 5\n"), HasSubstr("finite"));
  EXPECT_EQ(
      cornersOf(MeshFile("a.obj", std::string(kSquare) + "v 1e99 0 0\nf 1 2 5\nf 1/7/9 2/7/9 3/7/9\n").load()).size(),
      3u);
  EXPECT_THAT(withMtl("Kd red\n").error(), HasSubstr("a b.mtl: line 2"));
  EXPECT_THAT(withMtl("map_Kd -s 2 2 2\n").error(), HasSubstr("names no image"));
  MeshFile image = withMtl("map_Kd color.png\n");
  image.add("color.png", "no image");
  EXPECT_THAT(image.error(), HasSubstr("color.png is not a JPEG"));
}

}  // namespace
}  // namespace latelight::scene::test
