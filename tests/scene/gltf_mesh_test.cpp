// Topology, normals, tangents, colors, morph targets and skins.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "gltf_builder.h"
#include "models/parts.h"
#include "scene/tangents.h"

namespace latelight::scene::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// Five points with normals, so that vertices stay shared, drawn with this primitive mode.
Scene drawn(int mode) {
  GltfBuilder b;
  int p = b.positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 2, 0}});
  int n = b.vectors(std::vector<vec3>(5, vec3(0, 0, 1)));
  b.mesh({{"attributes", {{"POSITION", p}, {"NORMAL", n}}}, {"mode", mode}});
  return b.load();
}

TEST(GltfMesh, ListsStripsAndFans) {
  EXPECT_THAT(drawn(4).meshes[0].indices, ElementsAre(0, 1, 2));  // the rest of a list is not a triangle
  EXPECT_THAT(drawn(5).meshes[0].indices, ElementsAre(0, 1, 2, 1, 3, 2, 2, 3, 4));
  EXPECT_THAT(drawn(6).meshes[0].indices, ElementsAre(1, 2, 0, 2, 3, 0, 3, 4, 0));
}

// A list of triangles has a multiple of three corners (glTF 2.0, 3.7.2.1).
TEST(GltfMesh, CornersAfterTheLastTriangleAreSkippedWithAWarning) {
  const auto load = [](const std::vector<uint8_t>& indices, bool indexed) {
    GltfBuilder b;
    json primitive = {{"attributes", {{"POSITION", b.positions(std::vector<vec3>(indices.size(), vec3(0)))}}}};
    if (indexed) primitive["indices"] = b.accessor(b.view(indices), kUnsignedByte, "SCALAR", indices.size());
    b.mesh(primitive);
    testing::internal::CaptureStderr();
    EXPECT_EQ(b.load().meshes.at(0).indices.size(), 3u);
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(load({0, 1, 2}, true), "");
  EXPECT_EQ(load({0, 1, 2}, false), "");
  EXPECT_THAT(load({0, 1, 2, 3}, true), HasSubstr("has 4 indices, which is not a multiple of 3: the last one is"));
  EXPECT_THAT(load({0, 1, 2, 3, 4}, true), HasSubstr("has 5 indices, which is not a multiple of 3: the last two are"));
  EXPECT_THAT(load({0, 1, 2, 3}, false), HasSubstr("has 4 vertices, which is not a multiple of 3: the last one is"));
}

TEST(GltfMesh, PointsAndLinesAreLeftOut) {
  for (int mode : {0, 1, 2, 3}) {
    Scene scene = drawn(mode);
    EXPECT_TRUE(scene.meshes.empty());
    EXPECT_TRUE(scene.instances.empty());
    EXPECT_EQ(scene.nodes.size(), 1u);
  }
}

TEST(GltfMesh, OnlyTheUsedRangeOfSharedBuffersIsKept) {
  GltfBuilder b;
  std::vector<vec3> many(1000, vec3(9));
  many[500] = {0, 0, 0}, many[501] = {1, 0, 0}, many[502] = {0, 1, 0};
  int p = b.positions(many), n = b.vectors(std::vector<vec3>(1000, vec3(0, 0, 1)));
  int i = b.accessor(b.view(std::vector<uint16_t>{500, 501, 502}), kUnsignedShort, "SCALAR", 3);
  b.mesh({{"attributes", {{"POSITION", p}, {"NORMAL", n}}}, {"indices", i}});
  Scene scene = b.load();
  EXPECT_THAT(scene.meshes[0].positions, ElementsAre(many[500], many[501], many[502]));
  EXPECT_THAT(scene.meshes[0].indices, ElementsAre(0, 1, 2));
  EXPECT_EQ(scene.meshes[0].boundsMax, vec3(1, 1, 0));
}

TEST(GltfMesh, MissingNormalsAreFlat) {
  GltfBuilder b;
  int p = b.positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  int i = b.accessor(b.view(std::vector<uint8_t>{0, 1, 2, 0, 3, 1}), kUnsignedByte, "SCALAR", 6);
  b.mesh({{"attributes", {{"POSITION", p}}}, {"indices", i}});
  Scene scene = b.load();
  const Mesh& mesh = scene.meshes[0];
  ASSERT_EQ(mesh.positions.size(), 6u);
  EXPECT_THAT(mesh.indices, ElementsAre(0, 1, 2, 3, 4, 5));
  for (size_t v : {0, 1, 2}) EXPECT_EQ(mesh.attributes[v].normal, vec3(0, 0, 1));
  for (size_t v : {3, 4, 5}) EXPECT_EQ(mesh.attributes[v].normal, vec3(0, 1, 0));
  EXPECT_TRUE(mesh.extras.empty());
  EXPECT_EQ(mesh.attributes[0].tangent, vec4(0));
}

TEST(GltfMesh, BrokenNormalsAreMended) {
  GltfBuilder b = triangleFile();
  float nan = std::numeric_limits<float>::quiet_NaN();
  b.primitive()["attributes"]["NORMAL"] = b.vectors(std::vector<vec3>{{0, 0, 0}, {nan, 0, 0}, {3, 0, 4}});
  Scene scene = b.load();
  EXPECT_EQ(scene.meshes[0].attributes[0].normal, vec3(0, 0, 1));
  EXPECT_EQ(scene.meshes[0].attributes[1].normal, vec3(0, 0, 1));
  expectNear(scene.meshes[0].attributes[2].normal, vec3(.6f, 0, .8f));
}

TEST(GltfMesh, ColorsOfEveryKind) {
  auto colorsOf = [](Component component, const char* type, auto values) {
    GltfBuilder b = triangleFile();
    int stride = int((values.size() / 3 * sizeof(values[0]) + 3) / 4 * 4);
    size_t bytes = values.size() / 3 * sizeof(values[0]);
    std::vector<std::byte> padded(size_t(stride) * 3);
    for (size_t i = 0; i < 3; ++i)
      std::memcpy(&padded[i * size_t(stride)], reinterpret_cast<std::byte*>(values.data()) + i * bytes, bytes);
    b.primitive()["attributes"]["COLOR_0"] = b.accessor(b.view(padded, stride), component, type, 3);
    b.root["accessors"].back()["normalized"] = component != kFloat;
    return b.load().meshes[0].extras.at(1).color;
  };
  EXPECT_EQ(colorsOf(kFloat, "VEC3", std::vector<float>{0, 0, 0, 1, .5f, .25f, 0, 0, 0}), vec4(1, .5f, .25f, 1));
  EXPECT_EQ(colorsOf(kFloat, "VEC4", std::vector<float>{0, 0, 0, 0, 1, .5f, .25f, .125f, 0, 0, 0, 0}),
            vec4(1, .5f, .25f, .125f));
  EXPECT_EQ(colorsOf(kUnsignedByte, "VEC3", std::vector<uint8_t>{0, 0, 0, 255, 51, 0, 0, 0, 0}), vec4(1, .2f, 0, 1));
  EXPECT_EQ(colorsOf(kUnsignedByte, "VEC4", std::vector<uint8_t>{0, 0, 0, 0, 255, 51, 0, 102, 0, 0, 0, 0}),
            vec4(1, .2f, 0, .4f));
  EXPECT_EQ(colorsOf(kUnsignedShort, "VEC3", std::vector<uint16_t>{0, 0, 0, 65535, 13107, 0, 0, 0, 0}),
            vec4(1, .2f, 0, 1));
  EXPECT_EQ(colorsOf(kUnsignedShort, "VEC4", std::vector<uint16_t>{0, 0, 0, 0, 65535, 13107, 0, 26214, 0, 0, 0, 0}),
            vec4(1, .2f, 0, .4f));
}

// --- tangents
// ---------------------------------------------------------------------------------------------------------

TEST(Tangents, FollowUAndPointUpWhereVFallsDown) {
  std::vector<vec3> p = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, n(3, vec3(0, 0, 1));
  std::vector<vec2> upright = {{0, 1}, {1, 1}, {0, 0}}, mirrored = {{1, 1}, {0, 1}, {1, 0}};
  std::vector<uint32_t> indices = {0, 1, 2};
  for (const vec4& t : generateTangents(p, n, upright, indices).tangents) EXPECT_EQ(t, vec4(1, 0, 0, 1));
  for (const vec4& t : generateTangents(p, n, mirrored, indices).tangents) EXPECT_EQ(t, vec4(-1, 0, 0, -1));
}

TEST(Tangents, SplitWhereMirroredHalvesMeet) {
  // Two triangles share an edge; on the second one, u runs backward.
  std::vector<vec3> p = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}}, n(4, vec3(0, 0, 1));
  std::vector<vec2> uv = {{0, 1}, {1, 1}, {0, 0}, {1, 1}};
  std::vector<uint32_t> indices = {0, 1, 2, 0, 2, 3};
  TangentFrames frames = generateTangents(p, n, uv, indices);
  EXPECT_THAT(frames.copies, ElementsAre(0, 2));
  EXPECT_THAT(indices, ElementsAre(0, 1, 2, 4, 5, 3));
  for (uint32_t v : {0, 1, 2}) EXPECT_EQ(frames.tangents[v], vec4(1, 0, 0, 1));
  for (uint32_t v : {3, 4, 5}) EXPECT_EQ(frames.tangents[v], vec4(-1, 0, 0, -1));
}

TEST(Tangents, EqualVerticesShareTheirsThoughNotTheirIndex) {
  // A fold: the same two corners twice, with one normal. Each side by itself would tilt its tangent.
  vec3 normal = glm::normalize(vec3(0, 0, 1));
  std::vector<vec3> p = {{0, 0, 0}, {0, 1, 0}, {1, 0.5f, 0.5f}, {0, 0, 0}, {0, 1, 0}, {-1, 0.2f, 0.5f}}, n(6, normal);
  std::vector<vec2> uv = {{.5f, 1}, {.5f, 0}, {1, .4f}, {.5f, 1}, {.5f, 0}, {0, .8f}};
  std::vector<uint32_t> indices = {0, 2, 1, 3, 4, 5};
  TangentFrames frames = generateTangents(p, n, uv, indices);
  EXPECT_EQ(frames.tangents[0], frames.tangents[3]);
  EXPECT_EQ(frames.tangents[1], frames.tangents[4]);
  EXPECT_NE(frames.tangents[2], frames.tangents[5]);
}

TEST(Tangents, DegenerateUvsStillGiveAFrame) {
  std::vector<vec3> p = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, n(3, glm::normalize(vec3(1, 2, 3)));
  std::vector<uint32_t> indices = {0, 1, 2};
  for (const vec4& t : generateTangents(p, n, std::vector<vec2>(3, vec2(0)), indices).tangents) {
    EXPECT_NEAR(glm::length(vec3(t)), 1, 1e-6f);
    EXPECT_NEAR(glm::dot(vec3(t), n[0]), 0, 1e-6f);
    EXPECT_EQ(std::abs(t.w), 1);
  }
}

GltfBuilder normalMapped() {
  GltfBuilder b = triangleFile();
  b.primitive()["attributes"]["NORMAL"] = b.vectors(std::vector<vec3>(3, vec3(0, 0, 1)));
  b.primitive()["material"] = b.add("materials", {{"normalTexture", {{"index", b.add("textures", {{"source", 0}})}}}});
  // A 1x1 BMP: headers of 14 and 40 bytes, one pixel of 24 bits.
  std::vector<uint8_t> bmp = {'B', 'M', 58, 0, 0, 0, 0, 0, 0, 0, 54, 0, 0, 0,  40,
                              0,   0,   0,  1, 0, 0, 0, 1, 0, 0, 0,  1, 0, 24, 0};
  bmp.resize(54);
  bmp.insert(bmp.end(), {255, 128, 128, 0});
  b.add("images", {{"bufferView", b.view(bmp)}, {"mimeType", "image/bmp"}});
  return b;
}

TEST(GltfMesh, TangentsAreMadeForNormalMapsOnly) {
  GltfBuilder b = normalMapped();
  EXPECT_EQ(b.load().meshes[0].attributes[0].tangent, vec4(1, 0, 0, 1));
  // Tangents follow the texture's transform: a quarter turn.
  b.root["materials"][0]["normalTexture"]["extensions"]["KHR_texture_transform"] = {{"rotation", std::acos(0.0)}};
  Scene turned = b.load();
  expectNear(vec3(turned.meshes[0].attributes[0].tangent), vec3(0, -1, 0));
  EXPECT_EQ(turned.meshes[0].attributes[0].tangent.w, 1);
  b.root["materials"][0].erase("normalTexture");
  EXPECT_EQ(b.load().meshes[0].attributes[0].tangent, vec4(0));
  EXPECT_EQ(b.load({.tangents = true}).meshes[0].attributes[0].tangent, vec4(1, 0, 0, 1));
}

TEST(GltfMesh, TangentsOfTheFileAreKept) {
  GltfBuilder b = normalMapped();
  b.primitive()["attributes"]["TANGENT"] = b.vectors(std::vector<vec4>(3, vec4(0, 2, 0, -1)));
  EXPECT_EQ(b.load().meshes[0].attributes[0].tangent, vec4(0, 1, 0, -1));
  b.primitive()["attributes"].erase("NORMAL");  // without normals, tangents must be ignored
  EXPECT_EQ(b.load().meshes[0].attributes[0].tangent, vec4(1, 0, 0, 1));
}

// --- poses
// ------------------------------------------------------------------------------------------------------------

TEST(GltfMesh, MorphTargetsByDefaultWeights) {
  GltfBuilder b = triangleFile();
  b.primitive()["attributes"]["NORMAL"] = b.vectors(std::vector<vec3>(3, vec3(0, 0, 1)));
  int up = b.positions(std::vector<vec3>(3, vec3(0, 0, 4))), side = b.positions(std::vector<vec3>(3, vec3(8, 0, 0)));
  int tilt = b.vectors(std::vector<vec3>(3, vec3(0, 2, 0)));
  b.primitive()["targets"] = {{{"POSITION", up}}, {{"POSITION", side}, {"NORMAL", tilt}}};
  EXPECT_EQ(b.load().meshes[0].positions[0], vec3(0));
  b.root["meshes"][0]["weights"] = {0.5, 0.25};
  Scene scene = b.load();
  EXPECT_EQ(scene.meshes[0].positions[0], vec3(2, 0, 2));
  expectNear(scene.meshes[0].attributes[0].normal, glm::normalize(vec3(0, .5f, 1)));
  b.root["nodes"][0]["weights"] = {1, 0};  // a node's own weights take precedence
  EXPECT_EQ(b.load().meshes[0].positions[0], vec3(0, 0, 4));
}

// Animates the weight of the only morph target from 1 to 1.
void holdWeight(GltfBuilder& b) {
  const int times = b.accessor(b.view(std::vector<float>{0, 1}), kFloat, "SCALAR", 2);
  const int weights = b.accessor(b.view(std::vector<float>{1, 1}), kFloat, "SCALAR", 2);
  b.add("animations", {{"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}},
                       {"samplers", {{{"input", times}, {"output", weights}}}}});
}

// The target shears the triangle in its plane.
TEST(GltfMesh, GeneratedTangentsAreThoseOfTheUndeformedMesh) {
  GltfBuilder b = normalMapped();
  b.primitive()["targets"] = {{{"POSITION", b.positions({{0, 0, 0}, {0, 1, 0}, {0, 0, 0}})}}};
  b.root["meshes"][0]["weights"] = {1};
  for (const bool animated : {false, true}) {
    if (animated) holdWeight(b);
    const Mesh mesh = b.load().meshes[0];
    EXPECT_EQ(mesh.positions[1], vec3(1, 1, 0));
    EXPECT_EQ(mesh.attributes[1].tangent, vec4(1, 0, 0, 1)) << (animated ? "animated" : "at rest");
  }
}

TEST(GltfMesh, SkinsAreInTheirJointsPoseAndIgnoreTheirNode) {
  GltfBuilder b = triangleFile();
  b.primitive()["attributes"]["NORMAL"] = b.vectors(std::vector<vec3>(3, vec3(0, 0, 1)));
  std::vector<uint8_t> joints = {0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0};
  std::vector<vec4> weights = {{1, 0, 0, 0}, {2, 0, 0, 0}, {.5f, .5f, 0, 0}};
  b.primitive()["attributes"]["JOINTS_0"] = b.accessor(b.view(joints), kUnsignedByte, "VEC4", 3);
  b.primitive()["attributes"]["WEIGHTS_0"] = b.vectors(weights);
  glm::mat4 shift(1);
  shift[3] = vec4(-1, 0, 0, 1);
  std::vector<glm::mat4> inverse = {glm::mat4(1), shift};
  int ibm = b.accessor(b.view(inverse), kFloat, "MAT4", 2);
  int arm = b.node({{"translation", {0, 0, 10}}, {"children", {2}}, {"name", "arm"}});
  ASSERT_EQ(arm, 1);
  b.add("nodes", {{"translation", {1, 0, 0}}, {"scale", {2, 2, 2}}, {"name", "hand"}});
  b.add("skins", {{"joints", {1, 2}}, {"inverseBindMatrices", ibm}});
  b.root["nodes"][0]["skin"] = 0;
  b.root["nodes"][0]["translation"] = {100, 100, 100};
  Scene scene = b.load();
  ASSERT_EQ(scene.meshes.size(), 1u);
  expectNear(scene.meshes[0].positions[0], vec3(0, 0, 10));
  expectNear(scene.meshes[0].positions[1], vec3(1, 0, 10));        // (1,0,0) minus the shift is the hand's origin
  expectNear(scene.meshes[0].positions[2], vec3(-.5f, 1.5f, 10));  // halfway between (0,1,10) and (-1,2,10)
  expectNear(scene.meshes[0].attributes[1].normal, vec3(0, 0, 1));
  EXPECT_EQ(scene.instances[0].toWorld, toWorldFromGltf());

  joints[0] = 2;
  b.primitive()["attributes"]["JOINTS_0"] = b.accessor(b.view(joints), kUnsignedByte, "VEC4", 3);
  EXPECT_THAT(errorOf(b), HasSubstr("names joint 2 of skins[0], which has 2"));
  // With a weight of 0, the joint may be any.
  std::swap(joints[0], joints[1]);
  b.primitive()["attributes"]["JOINTS_0"] = b.accessor(b.view(joints), kUnsignedByte, "VEC4", 3);
  expectNear(b.load().meshes[0].positions[0], vec3(0, 0, 10));
}

// --- values that are no numbers -------------------------------------------------------------------------------------

// Two triangles with these attributes in addition to their positions.
GltfBuilder twoTriangles() {
  GltfBuilder b;
  const int p = b.positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}, {3, 0, 0}, {2, 1, 0}});
  b.mesh({{"attributes", {{"POSITION", p}}}});
  return b;
}

TEST(GltfMesh, ValuesThatAreNotFiniteAreRepaired) {
  GltfBuilder b = twoTriangles();
  json& attributes = b.primitive()["attributes"];
  std::vector<vec2> uv(6, {0.25f, 0.5f});
  std::vector<vec3> normals(6, {0, 0, 1});
  std::vector<vec4> colors(6, {0.5f, 0.25f, 0.125f, 0.75f}), tangents(6, {0, 1, 0, -1});
  uv[1].y = NAN, uv[2].x = INFINITY, normals[3].z = NAN, colors[4].a = NAN, tangents[5].x = -INFINITY;
  attributes["TEXCOORD_0"] = attributes["TEXCOORD_1"] = b.vectors(uv);
  attributes["NORMAL"] = b.vectors(normals);
  attributes["TANGENT"] = b.vectors(tangents);
  attributes["COLOR_0"] = b.vectors(colors);
  b.root["accessors"][0]["min"] = {nullptr, 0, 0};  // as exporters write the bounds of such values
  testing::internal::CaptureStderr();
  const Mesh mesh = b.load().meshes.at(0);
  const std::string warning = testing::internal::GetCapturedStderr();
  EXPECT_THAT(warning, HasSubstr("meshes[0].primitives[0].COLOR_0 and 4 other attributes of the file have values that "
                                 "are not finite numbers"));
  EXPECT_EQ(std::count(warning.begin(), warning.end(), '\n'), 1) << "one warning";
  EXPECT_EQ(mesh.attributes[0].uv0, vec2(0.25f, 0.5f));
  EXPECT_EQ(mesh.attributes[1].uv0, vec2(0));
  EXPECT_EQ(mesh.attributes[2].uv0, vec2(0));
  EXPECT_EQ(mesh.extras[2].uv1, vec2(0));
  EXPECT_EQ(mesh.attributes[3].normal, vec3(0, 0, 1)) << "the triangle's";
  EXPECT_EQ(mesh.attributes[4].tangent, vec4(0, 1, 0, -1));
  EXPECT_EQ(mesh.attributes[5].tangent, vec4(0)) << "no tangent frame";
  EXPECT_EQ(mesh.extras[3].color, vec4(0.5f, 0.25f, 0.125f, 0.75f));
  EXPECT_EQ(mesh.extras[4].color, vec4(1));
}

TEST(GltfMesh, TrianglesWithoutPositionsAreLeftOut) {
  GltfBuilder b;
  std::vector<vec3> positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}, {NAN, 0, 0}, {2, 1, 0}};
  b.mesh({{"attributes", {{"POSITION", b.positions(positions)}}}});
  const Mesh mesh = b.load().meshes.at(0);
  EXPECT_EQ(mesh.indices.size(), 3u);
  EXPECT_EQ(mesh.positions.at(1), vec3(1, 0, 0));
  EXPECT_LE(mesh.boundsMax.x, 2);
  GltfBuilder none;
  none.mesh({{"attributes", {{"POSITION", none.positions({{0, 0, 0}, {NAN, 0, 0}, {0, 1, 0}})}}}});
  EXPECT_THAT(errorOf(none), HasSubstr("has no triangle whose positions are finite numbers"));
}

TEST(GltfMesh, MorphTargetsThatAreNotFiniteMoveNothing) {
  GltfBuilder b = twoTriangles();
  std::vector<vec3> deltas(6, {0, 0, 1});
  deltas[2].x = NAN;
  b.primitive()["targets"] = {{{"POSITION", b.vectors(deltas)}}};
  b.root["meshes"][0]["weights"] = {0.5};
  const Mesh mesh = b.load().meshes.at(0);
  EXPECT_EQ(mesh.positions[1], vec3(1, 0, 0.5f));
  EXPECT_EQ(mesh.positions[2], vec3(0, 1, 0));
}

// --- normals that point into the surface ----------------------------------------------------------------------------

TEST(GltfMesh, InvertedNormalsAreTurnedOver) {
  GltfBuilder b = triangleFile();
  const vec3 inverted(0, 0, -1), bent = glm::normalize(vec3(1, 0, -0.3f)), proper(0, 0, 1);
  json other = b.primitive();
  other["attributes"]["NORMAL"] = b.vectors(std::vector<vec3>{inverted, bent, proper});
  other["attributes"]["TANGENT"] = b.vectors(std::vector<vec4>(3, {1, 0, 0, 1}));
  b.root["meshes"][0]["primitives"].push_back(other);
  testing::internal::CaptureStderr();
  const Mesh mesh = b.load().meshes.at(1);
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              HasSubstr("meshes[0].primitives[1] has normals that point into its surface, which are turned over"));
  EXPECT_EQ(mesh.attributes[0].normal, proper);
  EXPECT_EQ(mesh.attributes[0].tangent, vec4(1, 0, 0, -1)) << "with the same bitangent";
  expectNear(mesh.attributes[1].normal, bent);  // as for the normals of leaves
  EXPECT_EQ(mesh.attributes[2].normal, proper);
  EXPECT_EQ(mesh.attributes[2].tangent, vec4(1, 0, 0, 1));
}

// At the pole of a sphere, rounding decides the winding of the triangle that has two corners there.
TEST(GltfMesh, NormalsOfSliversStay) {
  for (const auto& [radius, center] : {std::pair(1.0f, 0.0f), {1e-3f, 0.0f}, {1e4f, 0.0f}, {1.0f, 100.0f}}) {
    models::Shape shape = models::sphere(32, 16);
    for (vec3& position : shape.positions) position = position * radius + center;
    GltfBuilder b;
    b.mesh(models::primitive(b, shape, b.add("materials", json::object())));
    testing::internal::CaptureStderr();
    const Mesh mesh = b.load().meshes.at(0);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "radius " << radius << " around " << center;
    EXPECT_EQ(mesh.attributes.size(), shape.normals.size());
    for (size_t i = 0; i < shape.normals.size(); ++i) expectNear(mesh.attributes[i].normal, shape.normals[i]);
  }
}

// A flipped normal flips the morph target's displacement, too: (0, 0, -1) + (3, 0, 0) points along (3, 0, -1), which is
// (-3, 0, 1) when flipped.
TEST(GltfMesh, MorphTargetsFollowNormalsThatAreTurnedOver) {
  GltfBuilder b = triangleFile();
  b.primitive()["attributes"]["NORMAL"] = b.vectors(std::vector<vec3>(3, {0, 0, -1}));
  b.primitive()["targets"] = {{{"NORMAL", b.vectors(std::vector<vec3>(3, {3, 0, 0}))}}};
  b.root["meshes"][0]["weights"] = {1};
  for (const bool animated : {false, true}) {
    if (animated) holdWeight(b);
    const Mesh mesh = b.load().meshes.at(0);
    expectNear(mesh.attributes[0].normal, glm::normalize(vec3(-3, 0, 1)));
    EXPECT_EQ(mesh.deformation != nullptr, animated);
    if (!animated) continue;
    const DeformedVertices posed = deform(*mesh.deformation, {}, std::vector{1.0f});
    expectNear(posed.attributes[0].normal, glm::normalize(vec3(-3, 0, 1)));
  }
}

}  // namespace
}  // namespace latelight::scene::test
