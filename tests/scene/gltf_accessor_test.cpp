// Accessors of every kind, checked through the meshes that are loaded from them.
#include <gmock/gmock.h>

#include <limits>

#include "gltf_builder.h"

namespace latelight::scene::test {
namespace {

using testing::HasSubstr;

// A triangle whose TEXCOORD_0 has values of type T.
template <typename T>
Scene withTexcoords(Component component, bool normalized) {
  GltfBuilder b;
  int p = b.positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  using Limits = std::numeric_limits<T>;
  std::vector<T> values = {T(0), Limits::max(), Limits::min(), T(2), T(1), T(3)};
  int bytes = int(sizeof(T)) * 2;
  int stride = (bytes + 3) / 4 * 4;
  std::vector<std::byte> padded(size_t(stride) * 3);
  for (size_t i = 0; i < 3; ++i) std::memcpy(&padded[i * size_t(stride)], &values[i * 2], size_t(bytes));
  int t = b.accessor(b.view(padded, stride), component, "VEC2", 3);
  b.root["accessors"][size_t(t)]["normalized"] = normalized;
  b.mesh({{"attributes", {{"POSITION", p}, {"TEXCOORD_0", t}}}});
  return b.load();
}

template <typename T>
void checkIntegers(Component component) {
  using Limits = std::numeric_limits<T>;
  float most = float(Limits::max());
  const auto plain = withTexcoords<T>(component, false).meshes[0].attributes;
  EXPECT_EQ(plain[0].uv0, vec2(0, most));
  EXPECT_EQ(plain[1].uv0, vec2(float(Limits::min()), 2));
  EXPECT_EQ(plain[2].uv0, vec2(1, 3));
  const auto normalized = withTexcoords<T>(component, true).meshes[0].attributes;
  EXPECT_EQ(normalized[0].uv0, vec2(0, 1));
  EXPECT_EQ(normalized[1].uv0, vec2(Limits::min() == 0 ? 0.0f : -1.0f, 2 / most));  // -128 and -127 both map to -1
  EXPECT_EQ(normalized[2].uv0, vec2(1 / most, 3 / most));
}

TEST(GltfAccessor, EveryIntegerTypePlainAndNormalized) {
  checkIntegers<int8_t>(kByte);
  checkIntegers<uint8_t>(kUnsignedByte);
  checkIntegers<int16_t>(kShort);
  checkIntegers<uint16_t>(kUnsignedShort);
}

TEST(GltfAccessor, InterleavedVertices) {
  struct Vertex {
    vec3 position, normal;
    vec2 uv;
  };
  std::vector<Vertex> vertices = {
      {{0, 0, 0}, {0, 0, 1}, {.1f, .2f}}, {{1, 0, 0}, {0, 1, 0}, {.3f, .4f}}, {{0, 1, 0}, {1, 0, 0}, {.5f, .6f}}};
  GltfBuilder b;
  int view = b.view(vertices, sizeof(Vertex));
  int p = b.accessor(view, kFloat, "VEC3", 3), n = b.accessor(view, kFloat, "VEC3", 3),
      t = b.accessor(view, kFloat, "VEC2", 3);
  b.root["accessors"][size_t(n)]["byteOffset"] = 12;
  b.root["accessors"][size_t(t)]["byteOffset"] = 24;
  b.mesh({{"attributes", {{"POSITION", p}, {"NORMAL", n}, {"TEXCOORD_0", t}}}});
  Scene scene = b.load();
  const Mesh& mesh = scene.meshes[0];
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(mesh.positions[i], vertices[i].position);
    EXPECT_EQ(mesh.attributes[i].normal, vertices[i].normal);
    EXPECT_EQ(mesh.attributes[i].uv0, vertices[i].uv);
  }
  b.root["accessors"][size_t(t)]["byteOffset"] = 25;
  EXPECT_THAT(errorOf(b), HasSubstr("accessors[2] reaches to byte 97 of bufferViews[0], which has 96"));
}

json sparseOf(int indices, Component type, int values, size_t count) {
  return {{"count", count},
          {"indices", {{"bufferView", indices}, {"componentType", type}}},
          {"values", {{"bufferView", values}}}};
}

TEST(GltfAccessor, SparseOverValuesAndOverNothing) {
  for (Component type : {kUnsignedByte, kUnsignedShort, kUnsignedInt}) {
    GltfBuilder b = triangleFile();
    std::vector<std::byte> indices(type == kUnsignedByte ? 2 : type == kUnsignedShort ? 4 : 8);
    indices[0] = std::byte{1};
    indices[indices.size() / 2] = std::byte{2};
    b.root["accessors"][0]["sparse"] =
        sparseOf(b.view(indices), type, b.view(std::vector<vec3>{{5, 0, 0}, {0, 6, 0}}), 2);
    Scene scene = b.load();
    EXPECT_THAT(scene.meshes[0].positions, testing::ElementsAre(vec3(0, 0, 0), vec3(5, 0, 0), vec3(0, 6, 0)));
    b.root["accessors"][0].erase("bufferView");  // no buffer view: zeros
    b.root["accessors"][0]["sparse"]["count"] = 2;
    EXPECT_THAT(b.load().meshes[0].positions, testing::ElementsAre(vec3(0, 0, 0), vec3(5, 0, 0), vec3(0, 6, 0)));
  }
}

TEST(GltfAccessor, SparseIndexOutOfRange) {
  GltfBuilder b = triangleFile();
  int indices = b.view(std::vector<uint16_t>{0, 3});
  b.root["accessors"][0]["sparse"] =
      sparseOf(indices, kUnsignedShort, b.view(std::vector<vec3>{{5, 0, 0}, {0, 6, 0}}), 2);
  EXPECT_THAT(errorOf(b), HasSubstr("sparse index 3"));
}

template <typename T>
void checkIndices(Component component) {
  GltfBuilder b = triangleFile();
  b.primitive()["indices"] = b.accessor(b.view(std::vector<T>{2, 0, 1}), component, "SCALAR", 3);
  Scene scene = b.load();
  // Normals are missing, so the vertices are duplicated in the order of the indices.
  EXPECT_EQ(scene.meshes[0].positions[0], vec3(0, 1, 0));
  EXPECT_EQ(scene.meshes[0].positions[2], vec3(1, 0, 0));
  b.primitive()["indices"] = b.accessor(b.view(std::vector<T>{2, 0, 3}), component, "SCALAR", 3);
  EXPECT_THAT(errorOf(b), HasSubstr("has the index 3, but 3 vertices"));
}

TEST(GltfAccessor, IndicesOfEveryType) {
  checkIndices<uint8_t>(kUnsignedByte);
  checkIndices<uint16_t>(kUnsignedShort);
  checkIndices<uint32_t>(kUnsignedInt);
  GltfBuilder b = triangleFile();
  b.primitive()["indices"] = b.accessor(b.view(std::vector<int16_t>{2, 0, 1}), kShort, "SCALAR", 3);
  EXPECT_THAT(errorOf(b), HasSubstr("should hold indices"));
}

TEST(GltfAccessor, IndicesWithoutBufferViewAreZeros) {
  GltfBuilder b = triangleFile();
  b.primitive()["indices"] = b.add("accessors", {{"componentType", kUnsignedShort}, {"type", "SCALAR"}, {"count", 3}});
  EXPECT_EQ(b.load().meshes[0].indices.size(), 3u);
}

TEST(GltfAccessor, AFewBytesCantAskForGigabytes) {
  GltfBuilder b = triangleFile();
  json& accessor = b.root["accessors"][0];
  accessor.erase("bufferView");
  accessor["count"] = 4000000000u;
  b.root["accessors"][1] = accessor;
  EXPECT_THAT(errorOf(b), HasSubstr("far more than a file of this size can contain"));
}

TEST(GltfAccessor, ValuesThatAreNoNumbers) {
  GltfBuilder b = triangleFile();
  float infinite = std::numeric_limits<float>::infinity();
  b.primitive()["attributes"]["POSITION"] = b.positions({{0, 0, 0}, {infinite, 0, 0}, {0, 1, 0}});
  EXPECT_THAT(errorOf(b), HasSubstr("has no triangle whose positions are finite numbers"));
}

// An accessor of three elements without a buffer view, whose values are zeros.
int zeros(GltfBuilder& b, int component, const char* type) {
  return b.add("accessors", {{"componentType", component}, {"type", type}, {"count", 3}});
}

struct TypeCase {
  const char* attribute;
  int component;
  const char* type;
};

// A triangle with a skin, all attributes, and a morph target, of which one attribute has another type.
std::string errorOfTypes(const TypeCase& vertices, const TypeCase& target) {
  GltfBuilder b = triangleFile();
  const int joint = b.node({{"name", "joint"}});
  b.add("skins", {{"joints", {joint}}});
  b.root["nodes"][0]["skin"] = 0;
  b.primitive()["attributes"] = {{"POSITION", b.positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}})},
                                 {"NORMAL", zeros(b, kFloat, "VEC3")},
                                 {"COLOR_0", zeros(b, kFloat, "VEC4")},
                                 {"JOINTS_0", zeros(b, kUnsignedByte, "VEC4")},
                                 {"WEIGHTS_0", zeros(b, kFloat, "VEC4")}};
  b.primitive()["targets"] = {{{"POSITION", zeros(b, kFloat, "VEC3")}, {"COLOR_0", zeros(b, kFloat, "VEC4")}}};
  b.root["meshes"][0]["weights"] = {1};
  if (vertices.attribute) b.primitive()["attributes"][vertices.attribute] = zeros(b, vertices.component, vertices.type);
  if (target.attribute) b.primitive()["targets"][0][target.attribute] = zeros(b, target.component, target.type);
  try {
    b.load();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::BadInput);
    return error.what();
  }
  return {};
}

// glTF 2.0 (3.7.2.1 and 3.7.2.2) and KHR_mesh_quantization, which need not be declared.
TEST(GltfAccessor, TypesThatFit) {
  for (const int component : {kByte, kUnsignedByte, kShort, kUnsignedShort}) {
    EXPECT_EQ(errorOfTypes({"TEXCOORD_1", component, "VEC2"}, {}), "");
    EXPECT_EQ(errorOfTypes({}, {"TEXCOORD_0", component, "VEC2"}), "");
    EXPECT_EQ(errorOfTypes({}, {"COLOR_0", component, "VEC3"}), "");
  }
  for (const int component : {kByte, kShort, kFloat}) {
    EXPECT_EQ(errorOfTypes({"NORMAL", component, "VEC3"}, {}), "");
    EXPECT_EQ(errorOfTypes({"TANGENT", component, "VEC4"}, {}), "");
    for (const char* attribute : {"POSITION", "NORMAL", "TANGENT"})
      EXPECT_EQ(errorOfTypes({}, {attribute, component, "VEC3"}), "");
  }
  for (const int component : {kUnsignedByte, kUnsignedShort, kFloat})
    for (const char* type : {"VEC3", "VEC4"}) EXPECT_EQ(errorOfTypes({"COLOR_0", component, type}, {}), "");
  for (const int component : {kUnsignedByte, kUnsignedShort}) {
    EXPECT_EQ(errorOfTypes({"JOINTS_0", component, "VEC4"}, {}), "");
    EXPECT_EQ(errorOfTypes({"WEIGHTS_0", component, "VEC4"}, {}), "");
  }
  // Attributes that are not read may have any type.
  for (const char* attribute : {"_HEAT", "TEXCOORD_2", "COLOR_1"})
    EXPECT_EQ(errorOfTypes({attribute, kUnsignedInt, "MAT3"}, {}), "");
}

TEST(GltfAccessor, TypesThatDoNotFit) {
  EXPECT_THAT(errorOfTypes({"POSITION", kFloat, "VEC2"}, {}),
              HasSubstr("meshes[0].primitives[0].POSITION is VEC2 of FLOAT, in accessors[9]; it must be VEC3 of FLOAT, "
                        "BYTE, UNSIGNED_BYTE, SHORT, UNSIGNED_SHORT"));
  EXPECT_THAT(errorOfTypes({"COLOR_0", kByte, "VEC3"}, {}),
              HasSubstr("meshes[0].primitives[0].COLOR_0 is VEC3 of BYTE, in accessors[9]; it must be VEC3 or VEC4 of "
                        "FLOAT, UNSIGNED_BYTE, UNSIGNED_SHORT"));
  for (const TypeCase& wrong : std::initializer_list<TypeCase>{{"POSITION", kFloat, "SCALAR"},
                                                               {"POSITION", kFloat, "MAT4"},
                                                               {"POSITION", kUnsignedInt, "VEC3"},
                                                               {"NORMAL", kFloat, "VEC2"},
                                                               {"NORMAL", kFloat, "VEC4"},
                                                               {"NORMAL", kUnsignedByte, "VEC3"},
                                                               {"TANGENT", kFloat, "VEC3"},
                                                               {"TANGENT", kFloat, "MAT2"},
                                                               {"TEXCOORD_0", kFloat, "SCALAR"},
                                                               {"TEXCOORD_0", kFloat, "VEC3"},
                                                               {"TEXCOORD_1", kFloat, "VEC4"},
                                                               {"TEXCOORD_0", kUnsignedInt, "VEC2"},
                                                               {"COLOR_0", kFloat, "SCALAR"},
                                                               {"COLOR_0", kFloat, "VEC2"},
                                                               {"JOINTS_0", kFloat, "VEC4"},
                                                               {"JOINTS_0", kByte, "VEC4"},
                                                               {"WEIGHTS_0", kFloat, "VEC3"},
                                                               {"WEIGHTS_0", kShort, "VEC4"}}) {
    const std::string error = errorOfTypes(wrong, {});
    EXPECT_THAT(error, HasSubstr(std::string(wrong.attribute) + " is " + wrong.type + " of "));
  }
  for (const TypeCase& wrong : std::initializer_list<TypeCase>{{"POSITION", kFloat, "VEC2"},
                                                               {"NORMAL", kUnsignedByte, "VEC3"},
                                                               {"TANGENT", kFloat, "VEC4"},
                                                               {"COLOR_0", kFloat, "VEC2"}}) {
    const std::string error = errorOfTypes({}, wrong);
    EXPECT_THAT(error, HasSubstr(std::string("targets[0].") + wrong.attribute + " is " + wrong.type + " of "));
  }
}

TEST(GltfAccessor, AttributesOfDifferentLengths) {
  GltfBuilder b = triangleFile();
  b.primitive()["attributes"]["TEXCOORD_0"] = b.vectors(std::vector<vec2>{{0, 0}, {1, 1}});
  EXPECT_THAT(errorOf(b), HasSubstr("has 2 of TEXCOORD_0, but 3 positions"));
}

}  // namespace
}  // namespace latelight::scene::test
