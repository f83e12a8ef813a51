// Complete files: containers, URIs, versions, extensions, and models from other sources.
#include <gmock/gmock.h>

#include <bit>
#include <cmath>

#include "error_of.h"
#include "gltf_builder.h"
#include "models/models.h"
#include "scene/gltf/load.h"

namespace latelight::scene::test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

std::string errorOfFile(const fs::path& path) {
  std::string message = errorOf([&] { loadGltf(path, {}); }, ExitCode::BadInput);
  EXPECT_THAT(message, HasSubstr(path.filename().string()));
  return message;
}

std::string errorOfBytes(std::span<const std::byte> bytes, const char* name = "scene.glb") {
  TemporaryFolder folder;
  writeBytes(folder.path() / name, bytes);
  std::string sentence = errorOfFile(folder.path() / name);
  EXPECT_FALSE(sentence.empty()) << "loaded without an error";
  return sentence;
}

std::string errorOfText(const std::string& text) {
  return errorOfBytes(std::as_bytes(std::span(text)), "scene.gltf");
}

TEST(GltfFiles, BinaryEmbeddedAndBesideAreTheSame) {
  GltfBuilder b = triangleFile();
  TemporaryFolder folder;
  writeBytes(folder.path() / "a.glb", b.glb());
  std::string text = b.embedded();
  writeBytes(folder.path() / "b.gltf", std::as_bytes(std::span(text)));
  writeBytes(folder.path() / "my data.bin", b.buffer);
  json beside = b.root;
  beside["buffers"] = {{{"byteLength", b.buffer.size()}, {"uri", "my%20data.bin"}}};
  text = beside.dump();
  writeBytes(folder.path() / "c.gltf", std::as_bytes(std::span(text)));
  Scene binary = loadGltf(folder.path() / "a.glb", {});
  EXPECT_EQ(binary.name, "a");
  EXPECT_TRUE(binary.yUp);
  ASSERT_EQ(binary.meshes.size(), 1u);
  for (const char* name : {"b.gltf", "c.gltf"}) {
    Scene other = loadGltf(folder.path() / name, {});
    ASSERT_EQ(other.meshes.size(), 1u);
    EXPECT_EQ(other.meshes[0].positions, binary.meshes[0].positions);
  }
  fs::remove(folder.path() / "my data.bin");
  EXPECT_THAT(errorOfFile(folder.path() / "c.gltf"), HasSubstr("my data.bin, which does not exist"));
}

TEST(GltfFiles, BrokenContainers) {
  std::vector<std::byte> good = triangleFile().glb();
  EXPECT_THAT(errorOfBytes(std::span(good).first(14)), HasSubstr("ends within its header"));
  EXPECT_THAT(errorOfBytes(std::span(good).first(good.size() - 4)), HasSubstr("copy it again"));
  std::vector<std::byte> bad = good;
  bad[4] = std::byte{1};
  EXPECT_THAT(errorOfBytes(bad), HasSubstr("version 1"));
  bad = good;
  bad[15] = std::byte{0x7f};
  EXPECT_THAT(errorOfBytes(bad), HasSubstr("past its end"));
  bad = good;
  bad[16] = std::byte{0};
  EXPECT_THAT(errorOfBytes(bad), HasSubstr("must be JSON"));
  EXPECT_THAT(errorOfBytes({}), HasSubstr("empty"));
}

// The header states a chunk length without padding; the padding exists or not.
std::vector<std::byte> unaligned(const GltfBuilder& b, bool padded) {
  std::vector<std::byte> bytes = b.glb();
  const size_t length = size_t(bytes[12]) | size_t(bytes[13]) << 8 | size_t(bytes[14]) << 16;
  EXPECT_EQ(bytes[20 + length - 1], std::byte{' '});  // there must be padding to omit
  for (size_t i = 0; i < 4; ++i) bytes[12 + i] = std::byte((length - 1) >> (8 * i));
  if (padded) return bytes;
  bytes.erase(bytes.begin() + std::ptrdiff_t(20 + length - 1));
  for (size_t i = 0; i < 4; ++i) bytes[8 + i] = std::byte(bytes.size() >> (8 * i));
  return bytes;
}

TEST(GltfFiles, ChunksThatAreNotAligned) {
  GltfBuilder b = triangleFile();
  while (b.glb()[20 + size_t(b.glb()[12]) + (size_t(b.glb()[13]) << 8) - 1] != std::byte{' '})
    b.root["asset"]["generator"] = b.root["asset"].value("generator", std::string()) + "x";
  const std::vector<vec3> wanted = b.load().meshes.at(0).positions;
  EXPECT_EQ(GltfBuilder::loadBytes(unaligned(b, true), "scene.glb").meshes.at(0).positions, wanted);
  testing::internal::CaptureStderr();
  EXPECT_EQ(GltfBuilder::loadBytes(unaligned(b, false), "scene.glb").meshes.at(0).positions, wanted);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("JSON chunk ends at byte"));
  std::vector<std::byte> broken = unaligned(b, false);
  const size_t end = 20 + (size_t(broken[12]) | size_t(broken[13]) << 8);
  broken[end + 3] = std::byte{0x7f};  // the binary chunk's length
  EXPECT_THAT(errorOfBytes(broken), HasSubstr("which is not a multiple of 4"));
}

TEST(GltfFiles, StayInTheirFolder) {
  TemporaryFolder folder;
  fs::create_directories(folder.path() / "scene");
  GltfBuilder b = triangleFile();
  writeBytes(folder.path() / "secret.bin", b.buffer);
  writeBytes(folder.path() / "scene/own.bin", b.buffer);
  fs::create_symlink("../secret.bin", folder.path() / "scene/link.bin");
  const fs::path scene = folder.path() / "scene/s.gltf";
  const auto write = [&](const std::string& uri) {
    b.root["buffers"] = {{{"byteLength", b.buffer.size()}, {"uri", uri}}};
    const std::string text = b.root.dump();
    writeBytes(scene, std::as_bytes(std::span(text)));
  };
  const std::string secret = (folder.path() / "secret.bin").string();
  for (const std::string& uri : {std::string("../secret.bin"), std::string("..%2fsecret.bin"),
                                 std::string("%2e%2e/secret.bin"), std::string("link.bin"), secret}) {
    write(uri);
    EXPECT_THAT(errorOfFile(scene), HasSubstr("outside the scene's folder")) << uri;
    EXPECT_EQ(loadGltf(scene, {.allowOutside = {folder.path().string()}}).meshes.size(), 1u) << uri;
  }
  for (const std::string& uri : {"file://" + secret, "file:" + secret, std::string("http://localhost/secret.bin")}) {
    write(uri);
    EXPECT_THAT(errorOfFile(scene), HasSubstr("only local files")) << uri;
    EXPECT_THROW(loadGltf(scene, {.allowOutside = {"/"}}), Error) << uri;
  }
  write("/proc/self/environ");
  EXPECT_THROW(loadGltf(scene, {.allowOutside = {"/"}}), Error);
  write("own.bin");
  EXPECT_EQ(loadGltf(scene, {}).meshes.size(), 1u);
  // This applies to images, too.
  b.add("images", {{"uri", "../secret.png"}});
  writeBytes(folder.path() / "secret.png", b.buffer);
  b.add("textures", {{"source", 0}});
  b.primitive()["material"] = b.add("materials", {{"normalTexture", {{"index", 0}}}});
  write("own.bin");
  EXPECT_THAT(errorOfFile(scene), AllOf(HasSubstr("images[0]"), HasSubstr("../secret.png"), HasSubstr("outside")));
}

TEST(GltfFiles, BrokenJson) {
  EXPECT_THAT(errorOfText("{"), HasSubstr("not glTF"));
  EXPECT_THAT(errorOfText("[]"), HasSubstr("asset"));
  EXPECT_THAT(errorOfText("{\"asset\": {}}"), HasSubstr("asset.version is missing"));
  EXPECT_THAT(errorOfText("{\"asset\": {\"version\": \"1.0\"}}"), HasSubstr("glTF 1.0"));
  EXPECT_THAT(errorOfText("{\"asset\": {\"version\": \"2.0\", \"minVersion\": \"2.1\"}}"), HasSubstr("2.1"));
  EXPECT_THAT(errorOfText("{\"asset\": {\"version\": \"2.0\"}, \"nodes\": 3}"), HasSubstr("nodes should be an array"));
  EXPECT_THAT(errorOfText("{\"asset\": {\"version\": \"2.0\"}, \"extras\": " + std::string(100000, '[') +
                          std::string(100000, ']') + "}"),
              HasSubstr("nested"));
  EXPECT_THAT(errorOfText("{\"asset\": {\"version\": \"2.0\"}, \"nodes\": [{\"scale\": [1e999, 1, 1]}]}"),
              HasSubstr("not glTF"));
  EXPECT_THAT(errorOfText("{\"asset\": {\"version\": \"2.0\"}, \"nodes\": [{\"scale\": [1e99, 1, 1]}]}"),
              HasSubstr("nodes[0].scale[0]"));
}

TEST(GltfFiles, Buffers) {
  GltfBuilder b = triangleFile();
  b.root["buffers"] = {{{"byteLength", 100000}}};
  EXPECT_THAT(errorOf(b), HasSubstr("buffers[0] should have 100000 bytes"));
  b.root["buffers"] = {{{"byteLength", 12}, {"uri", "https://example.com/a.bin"}}};
  EXPECT_THAT(errorOf(b), HasSubstr("only local files"));
  b.root["buffers"] = {{{"byteLength", 3}, {"uri", "data:;base64,AAA*"}}};
  EXPECT_THAT(errorOf(b), HasSubstr("base64"));
  b.root["buffers"] = {{{"byteLength", 3}, {"uri", "data:application/octet-stream"}}};
  EXPECT_THAT(errorOf(b), HasSubstr("data URI"));
}

// RFC 2397: data are a URI's characters, which may be percent-encoded. Schemes and parameters have any case.
TEST(GltfFiles, DataUrisOfAnyForm) {
  GltfBuilder b = triangleFile();
  const std::vector<vec3> positions = b.load().meshes.at(0).positions;
  b.buffer.resize(b.buffer.size() + 5, std::byte{0xff});
  std::string percent, everyByte;
  for (const char c : base64(b.buffer))
    percent += c == '/' ? "%2F" : c == '+' ? "%2b" : c == '=' ? "%3D" : std::string(1, c);
  EXPECT_THAT(percent, testing::EndsWith("%3D"));
  for (const std::byte byte : b.buffer) everyByte += fmt::format("%{:02x}", int(byte));
  std::string lines;  // of 76 characters (RFC 2045, 6.8)
  for (size_t i = 0; i < base64(b.buffer).size(); i += 76) lines += base64(b.buffer).substr(i, 76) + "\r\n";
  for (const std::string& uri : {"data:application/octet-stream;base64," + percent, "DATA:;BASE64," + base64(b.buffer),
                                 "Data:application/octet-stream;Base64," + percent, "data:," + everyByte,
                                 "data:;base64," + lines, "data:;base64,\t " + base64(b.buffer) + "%0A\f"}) {
    b.root["buffers"] = {{{"byteLength", b.buffer.size()}, {"uri", uri}}};
    EXPECT_EQ(b.load().meshes.at(0).positions, positions) << uri.substr(0, 60);
  }
  b.root["buffers"] = {{{"byteLength", 3}, {"uri", "data:;base64,AAA%2A"}}};
  EXPECT_THAT(errorOf(b), HasSubstr("base64"));
}

TEST(GltfFiles, RequiredExtensionsFailByName) {
  GltfBuilder b = triangleFile();
  b.root["extensionsUsed"] = {"KHR_materials_subsurface"};
  EXPECT_EQ(b.load().meshes.size(), 1u);
  b.root["extensionsRequired"] = {"KHR_materials_subsurface"};
  EXPECT_THAT(errorOf(b), HasSubstr("KHR_materials_subsurface"));
}

TEST(GltfFiles, MissingAndBrokenPictures) {
  GltfBuilder b = triangleFile();
  b.add("images", {{"uri", "nowhere.png"}});
  b.add("textures", {{"source", 0}});
  EXPECT_EQ(b.load().textures.size(), 0u);  // nothing refers to it
  b.primitive()["material"] = b.add("materials", {{"normalTexture", {{"index", 0}}}});
  EXPECT_THAT(errorOf(b), HasSubstr("nowhere.png"));
  b.root["images"][0] = {{"bufferView", b.view(std::vector<uint8_t>{1, 2, 3, 4})}, {"name", "rust"}};
  EXPECT_THAT(errorOf(b), HasSubstr("images[0] (rust) is not a"));
  b.root["images"][0] = {{"uri", "data:image/png;base64,"}};
  EXPECT_THAT(errorOf(b), HasSubstr("images[0] has 0 bytes"));
}

// --- models from elsewhere
// --------------------------------------------------------------------------------------------

const fs::path kAssimp = "/usr/share/assimp/models/glTF2";

TEST(GltfFiles, AssimpsGoodModels) {
  if (!fs::exists(kAssimp)) GTEST_SKIP() << "Debian's assimp-testmodels is not installed";
  for (const char* name :
       {"2CylinderEngine-glTF-Binary/2CylinderEngine.glb", "BoxBadNormals-glTF-Binary/BoxBadNormals.glb",
        "BoxTexcoords-glTF/boxTexcoords.gltf", "BoxTextured-glTF-Binary/BoxTextured.glb",
        "BoxTextured-glTF-Embedded/BoxTextured.gltf", "BoxTextured-glTF/BoxTextured.gltf",
        "BoxTextured-glTF-pbrSpecularGlossiness/BoxTextured.gltf", "ClearCoat-glTF/ClearCoatTest.gltf",
        "cameras/Cameras.gltf", "draco/2CylinderEngine.gltf",
        "glTF-Sample-Models/AnimatedMorphCube-glTF/AnimatedMorphCube.gltf", "issue_3269/texcoord_crash.gltf",
        "simple_skin/simple_skin.gltf", "textureTransform/TextureTransformTest.gltf"}) {
    Scene scene = loadGltf(kAssimp / name, {});
    EXPECT_GT(scene.triangleCount(), 0u) << name;
    EXPECT_FALSE(worldBounds(scene).empty()) << name;
  }
  for (int i = 0; i < 16; ++i) {
    std::string name = fmt::format("glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_{:02}.gltf", i);
    bool triangles = (i >= 4 && i <= 6) || i >= 11;
    EXPECT_EQ(loadGltf(kAssimp / name, {}).triangleCount(), triangles ? 2u : 0u) << name;
  }
  EXPECT_EQ(loadGltf(kAssimp / "TestNoRootNode/SceneWithoutNodes.gltf", {}).nodes.size(), 0u);
}

TEST(GltfFiles, AssimpsMalformedModels) {
  if (!fs::exists(kAssimp)) GTEST_SKIP() << "Debian's assimp-testmodels is not installed";
  for (const char* name :
       {"BoxTextured-glTF-techniqueWebGL/BoxTextured.gltf", "BoxWithInfinites-glTF-Binary/BoxWithInfinites.glb",
        "IncorrectVertexArrays/Cube.gltf", "IndexOutOfRange/AllIndicesOutOfRange.gltf",
        "IndexOutOfRange/IndexOutOfRange.gltf", "MissingBin/BoxTextured.gltf", "RecursiveNodes/RecursiveNodes.gltf",
        "SchemaFailures/sceneWrongType.gltf", "TestNoRootNode/NoScene.gltf", "wrongTypes/badArray.gltf",
        "wrongTypes/badExtension.gltf", "wrongTypes/badNumber.gltf", "wrongTypes/badObject.gltf",
        "wrongTypes/badString.gltf", "wrongTypes/badUint.gltf"})
    EXPECT_FALSE(errorOfFile(kAssimp / name).empty()) << name;
}

// The number of triangles, textures and their mip levels, and whether each mesh has tangents.
void expectTextured(const std::string& name, size_t triangles, size_t textures, uint32_t mostLevels) {
  SCOPED_TRACE(name);
  const Scene scene = loadGltf(models::modelPath(name), {});
  EXPECT_EQ(scene.triangleCount(), triangles);
  ASSERT_EQ(scene.textures.size(), textures);
  uint32_t most = 0;
  for (const Texture& texture : scene.textures) {
    EXPECT_EQ(texture.levels, uint32_t(std::bit_width(std::max(texture.width, texture.height))));
    most = std::max(most, texture.levels);
  }
  EXPECT_EQ(most, mostLevels);
  for (const Instance& instance : scene.instances) {
    if (scene.materials[instance.material].slots[shared::kTextureNormal].texture < 0) continue;
    for (const auto& attributes : scene.meshes[instance.mesh].attributes) {
      ASSERT_NEAR(glm::length(vec3(attributes.tangent)), 1, 1e-5f);
      ASSERT_NEAR(glm::dot(vec3(attributes.tangent), attributes.normal), 0, 1e-5f);
      ASSERT_EQ(std::abs(attributes.tangent.w), 1);
    }
  }
}

TEST(GltfFiles, TexturedModels) {
  expectTextured("many_materials.glb", 57'600, 50, 9);
  for (const std::string& name : models::withReal({}, {"DamagedHelmet.glb"})) expectTextured(name, 15'452, 5, 12);
}

// The lowest and highest point, and the length from back to front.
void expectUpright(const std::string& name, vec3 lowHighLong, float tolerance) {
  SCOPED_TRACE(name);
  const Bounds bounds = worldBounds(loadGltf(models::modelPath(name), {}));
  expectNear({bounds.min.z, bounds.max.z, bounds.max.y - bounds.min.y}, lowHighLong, tolerance);
}

TEST(GltfFiles, SkinnedModelsStandUpright) {
  expectUpright("skinned.glb", {0, 2, 0.6f}, 0.01f);
  for (const std::string& name : models::withReal({}, {"Fox.glb", "CesiumMan.glb"}))
    name == "Fox.glb" ? expectUpright(name, {-0.12f, 78.9f, 154.7f}, 0.2f)  // in centimeters
                      : expectUpright(name, {0, 1.507f, 1.138f}, 0.02f);
}

TEST(GltfFiles, ModelsWithPunctualLights) {
  for (const std::string& name : models::withReal({"punctual.glb"}, {"lights_punctual.glb"})) {
    const Scene scene = loadGltf(models::modelPath(name), {});
    EXPECT_EQ(scene.lights.size(), 3u) << name;
    EXPECT_EQ(scene.cameras.size(), 1u) << name;
  }
}

}  // namespace
}  // namespace latelight::scene::test
