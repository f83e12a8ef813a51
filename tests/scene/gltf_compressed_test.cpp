// Compressed geometry and textures: EXT_meshopt_compression, KHR_draco_mesh_compression, KHR_mesh_quantization and
// EXT_texture_webp, each encoded here by its own library.
#include <gmock/gmock.h>
#include <meshoptimizer.h>
#include <webp/encode.h>

#include <cmath>

#include "base/files.h"
#include "gltf_compressed_files.h"

namespace latelight::scene::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

TEST(GltfCompressed, MeshoptAttributesFiltersAndTriangles) {
  Grid grid;
  Scene scene = meshoptFile().load();
  const Mesh& mesh = scene.meshes.at(0);
  ASSERT_EQ(mesh.positions.size(), kVertices);
  EXPECT_EQ(mesh.positions, grid.positions);
  for (size_t v = 0; v < kVertices; ++v) {
    expectNear(mesh.attributes[v].normal, grid.normals[v], 2e-3f);
    expectNear(vec3(mesh.attributes[v].uv0, 0), vec3(vec2(grid.positions[v]), 0), 1e-5f);
  }
  // The codec may rotate a triangle's corners, but keeps their order and that of the triangles.
  ASSERT_EQ(mesh.indices.size(), grid.indices.size());
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    std::array<uint32_t, 3> a = {mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]};
    std::array<uint32_t, 3> wanted = {grid.indices[i], grid.indices[i + 1], grid.indices[i + 2]};
    while (a[0] != wanted[0] && a[1] != wanted[0] && a[2] != wanted[0]) FAIL() << "triangle " << i / 3;
    while (a[0] != wanted[0]) std::rotate(a.begin(), a.begin() + 1, a.end());
    EXPECT_EQ(a, wanted);
  }
}

TEST(GltfCompressed, MeshoptIndexSequences) {
  Grid grid;
  GltfBuilder b;
  int p = b.positions(grid.positions), n = b.vectors(grid.normals);
  std::vector<uint32_t> strip = {0, 1, 9, 10, 18, 19};
  std::vector<unsigned char> encoded(meshopt_encodeIndexSequenceBound(strip.size(), kVertices));
  encoded.resize(meshopt_encodeIndexSequence(encoded.data(), encoded.size(), strip.data(), strip.size()));
  int i = b.accessor(meshoptView(b, encoded, strip.size(), 4, "INDICES", "NONE"), kUnsignedInt, "SCALAR", strip.size());
  b.mesh({{"attributes", {{"POSITION", p}, {"NORMAL", n}}}, {"indices", i}, {"mode", 5}});
  finishMeshopt(b);
  EXPECT_THAT(b.load().meshes.at(0).indices, testing::ElementsAre(0, 1, 9, 1, 10, 9, 9, 10, 18, 10, 19, 18));
}

TEST(GltfCompressed, MeshoptQuaternionsOfInstances) {
  GltfBuilder b = triangleFile();
  float h = std::sqrt(0.5f);
  std::vector<vec4> rotations = {{0, 0, 0, 1}, {0, 0, h, h}};
  std::vector<std::array<int16_t, 4>> encoded(2);
  meshopt_encodeFilterQuat(encoded.data(), 2, 8, 16, &rotations[0].x);
  int r = b.accessor(meshoptView(b, encodeVertices(encoded), 2, 8, "ATTRIBUTES", "QUATERNION"), kShort, "VEC4", 2);
  b.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"ROTATION", r}};
  finishMeshopt(b);
  Scene scene = b.load();
  expectNear(vec3(toGltfFromWorld() * scene.instances.at(1).toWorld * vec4(1, 0, 0, 1)), vec3(0, 1, 0), 1e-3f);
}

TEST(GltfCompressed, BrokenMeshopt) {
  GltfBuilder b = meshoptFile();
  b.buffer.at(0) ^= std::byte{0xff};  // the header of the stream of positions
  EXPECT_THAT(errorOf(b), HasSubstr("bufferViews[1] cannot be decompressed"));
  b = meshoptFile();
  b.root["bufferViews"][1]["extensions"]["EXT_meshopt_compression"]["byteStride"] = 14;
  EXPECT_THAT(errorOf(b), HasSubstr("byteStride of 14"));
  b = meshoptFile();
  b.root["bufferViews"][1]["extensions"]["EXT_meshopt_compression"]["count"] = 4000000000u;
  EXPECT_THAT(errorOf(b), HasSubstr("far more than a file of this size can contain"));
  b = meshoptFile();
  b.root["bufferViews"][1].erase("extensions");
  EXPECT_THAT(errorOf(b), HasSubstr("which has 0"));  // the fallback buffer
}

// Files that require the extension omit the fallback's bytes, and many do not mark it as a fallback.
TEST(GltfCompressed, MeshoptWithoutAFallback) {
  GltfBuilder b = meshoptFile();
  b.root["buffers"][1].erase("extensions");
  EXPECT_EQ(b.load().meshes.at(0).positions, Grid().positions);
  b.root["bufferViews"][1].erase("extensions");  // now it is read
  EXPECT_THAT(errorOf(b), HasSubstr("buffers[1] has neither a uri"));
}

TEST(GltfCompressed, DracoByBothMethods) {
  Grid grid;
  for (int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    Scene scene = dracoFile(method).load();
    const Mesh& mesh = scene.meshes.at(0);
    ASSERT_EQ(mesh.indices.size(), grid.indices.size());
    ASSERT_EQ(mesh.positions.size(), kVertices);
    // EdgeBreaker reorders vertices: each must still lie on the sheet and have its normal, and the area must be the
    // same.
    double area = 0, wanted = 0;
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
      auto doubled = [&](const std::vector<vec3>& p, const std::vector<uint32_t>& x) {
        return double(glm::length(glm::cross(p[x[i + 1]] - p[x[i]], p[x[i + 2]] - p[x[i]])));
      };
      area += doubled(mesh.positions, mesh.indices);
      wanted += doubled(grid.positions, grid.indices);
    }
    EXPECT_NEAR(area, wanted, 1e-3);
    for (size_t v = 0; v < kVertices; ++v) {
      vec3 p = mesh.positions[v];
      EXPECT_NEAR(p.z, p.x * p.x / 2, 2e-4f);
      expectNear(mesh.attributes[v].normal, glm::normalize(vec3(-p.x, 0, 1)), 2e-2f);
    }
  }
}

TEST(GltfCompressed, BrokenDraco) {
  GltfBuilder b = dracoFile(draco::MESH_EDGEBREAKER_ENCODING);
  b.buffer.resize(b.buffer.size() / 2);
  b.root["bufferViews"][0]["byteLength"] = b.buffer.size();
  EXPECT_THAT(errorOf(b), HasSubstr("meshes[0].primitives[0] cannot be decompressed"));
  b = dracoFile(draco::MESH_SEQUENTIAL_ENCODING);
  // Changes the number of faces, stored in up to five bytes, to four billion.
  for (size_t i = 0; i < 4; ++i) b.buffer[11 + i] = std::byte{0xff};
  b.buffer[15] = std::byte{0x0f};
  EXPECT_THAT(errorOf(b), HasSubstr("far more than a file of this size can contain"));
  b = dracoFile(draco::MESH_SEQUENTIAL_ENCODING);
  b.primitive()["extensions"]["KHR_draco_mesh_compression"]["attributes"]["POSITION"] = 77;
  EXPECT_THAT(errorOf(b), HasSubstr("no compressed attribute 77"));
}

// Inserts metadata after the header of a Draco stream, which has 11 bytes.
GltfBuilder withMetadata(int method, const std::vector<uint8_t>& metadata) {
  GltfBuilder b = dracoFile(method);
  b.buffer[10] |= std::byte{0x80};  // the flag of metadata
  const auto bytes = std::as_bytes(std::span(metadata));
  b.buffer.insert(b.buffer.begin() + 11, bytes.begin(), bytes.end());
  b.root["bufferViews"][0]["byteLength"] = b.buffer.size();
  return b;
}

TEST(GltfCompressed, DracoWithMetadata) {
  // One attribute, of id 0: the entry "name" with the value "foo", and no metadata below it. The mesh: no entries, and
  // two elements below it. The first one, "a", has the entry "k" of one byte and an element "b" below it, which is
  // empty like the second one, "c".
  const std::vector<uint8_t> metadata = {1, 0, 1, 4,   'n', 'a', 'm', 'e', 3, 'f', 'o', 'o', 0,  //
                                         0, 2, 1, 'a', 1,   1,   'k', 1,   7, 1,   1,   'b', 0, 0, 1, 'c', 0, 0};
  for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    const Mesh mesh = withMetadata(method, metadata).load().meshes.at(0), plain = dracoFile(method).load().meshes.at(0);
    EXPECT_EQ(mesh.positions, plain.positions);
    EXPECT_EQ(mesh.indices, plain.indices);
  }
  std::vector<uint8_t> deep = {0, 0, 1};
  for (int i = 0; i < 10000; ++i) deep.insert(deep.end(), {0, 0, 1});
  deep.insert(deep.end(), {0, 0, 0});
  EXPECT_THAT(errorOf(withMetadata(draco::MESH_SEQUENTIAL_ENCODING, deep)), HasSubstr("is not a mesh of Draco's"));
  for (size_t size = 0; size < metadata.size(); ++size) {  // four billion entries or elements
    std::vector<uint8_t> broken(metadata.begin(), metadata.begin() + std::ptrdiff_t(size));
    broken.insert(broken.end(), {0xff, 0xff, 0xff, 0xff, 0x0f});
    EXPECT_FALSE(errorOf(withMetadata(draco::MESH_SEQUENTIAL_ENCODING, broken)).empty()) << size;
  }
}

TEST(GltfCompressed, DracoOfOtherTypes) {
  GltfBuilder b = dracoFile(draco::MESH_SEQUENTIAL_ENCODING);
  b.root["accessors"][1]["type"] = "VEC2";
  EXPECT_THAT(errorOf(b), HasSubstr("NORMAL has 3 compressed components per vertex, but accessors[1] has 2"));
  b = dracoFile(draco::MESH_SEQUENTIAL_ENCODING);
  b.root["accessors"][0]["componentType"] = kUnsignedInt;
  EXPECT_THAT(errorOf(b), HasSubstr("POSITION is VEC3 of UNSIGNED_INT, in accessors[0]; it must be VEC3 of FLOAT"));
  // The counts of many files are those before compression.
  b = dracoFile(draco::MESH_SEQUENTIAL_ENCODING);
  for (json& accessor : b.root["accessors"]) accessor["count"] = 66;
  EXPECT_EQ(b.load().meshes.at(0).positions.size(), kVertices);
}

// Two primitives of one stream, whose normals differ: the second one's are its positions.
TEST(GltfCompressed, DracoPrimitivesOfOneStream) {
  GltfBuilder b = dracoFile(draco::MESH_SEQUENTIAL_ENCODING);
  json other = b.primitive();
  json& ids = other["extensions"]["KHR_draco_mesh_compression"]["attributes"];
  ids["NORMAL"] = ids["POSITION"];
  b.mesh(b.primitive());
  b.mesh(other);
  const Scene scene = b.load();
  ASSERT_EQ(scene.instances.size(), 3u);
  EXPECT_EQ(scene.instances[1].mesh, scene.instances[0].mesh);
  ASSERT_NE(scene.instances[2].mesh, scene.instances[0].mesh);
  const Mesh& mesh = scene.meshes[scene.instances[2].mesh];
  expectNear(mesh.attributes[kVertices - 1].normal, glm::normalize(vec3(1, 1, 0.5f)), 1e-3f);
}

TEST(GltfCompressed, QuantizedPositions) {
  GltfBuilder b = triangleFile();
  std::vector<uint16_t> p = {0, 0, 0, 0, 1000, 0, 0, 0, 0, 2000, 0, 0};
  b.primitive()["attributes"]["POSITION"] = b.accessor(b.view(p, 8), kUnsignedShort, "VEC3", 3);
  std::vector<int8_t> n = {0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0};
  b.primitive()["attributes"]["NORMAL"] = b.accessor(b.view(n, 4), kByte, "VEC3", 3);
  b.root["accessors"].back()["normalized"] = true;
  b.root["extensionsUsed"] = b.root["extensionsRequired"] = {"KHR_mesh_quantization"};
  Scene scene = b.load();
  EXPECT_THAT(scene.meshes[0].positions, testing::ElementsAre(vec3(0), vec3(1000, 0, 0), vec3(0, 2000, 0)));
  EXPECT_EQ(scene.meshes[0].attributes[0].normal, vec3(0, 0, 1));
}

TEST(GltfCompressed, WebpTextures) {
  const uint8_t pixels[] = {200, 100, 50, 255, 10, 20, 30, 128};
  uint8_t* encoded = nullptr;
  size_t size = WebPEncodeLosslessRGBA(pixels, 2, 1, 8, &encoded);
  ASSERT_GT(size, 0u);
  GltfBuilder b = triangleFile();
  b.add("images", {{"bufferView", b.view(std::vector<uint8_t>(encoded, encoded + size))}, {"mimeType", "image/webp"}});
  WebPFree(encoded);
  b.add("textures", {{"extensions", {{"EXT_texture_webp", {{"source", 0}}}}}});
  b.primitive()["material"] = b.add("materials", {{"emissiveTexture", {{"index", 0}}}});
  b.root["extensionsUsed"] = b.root["extensionsRequired"] = {"EXT_texture_webp"};
  Scene scene = b.load();
  const Texture& texture = scene.textures.at(0);
  ASSERT_EQ(texture.width, 2u);
  EXPECT_EQ(texture.levels, 2u);
  EXPECT_EQ(std::memcmp(texture.pixels.get(), pixels, sizeof(pixels)), 0);
  // The extension may have no source; then the texture's own applies.
  b.root["textures"][0] = {{"source", 0}, {"extensions", {{"EXT_texture_webp", json::object()}}}};
  EXPECT_EQ(b.load().textures.size(), 1u);
  b.root["textures"][0] = {{"extensions", {{"EXT_texture_webp", json::object()}}}};
  EXPECT_EQ(b.load().textures.size(), 0u);
}

// KTX2 and AVIF images as textures; texture_ktx2_test.cpp and texture_test.cpp check the decoded values.
TEST(GltfCompressed, PicturesOfOtherExtensions) {
  const fs::path folder = fs::path(LATELIGHT_SOURCE_DIR) / "tests/scene/ktx2";
  const std::vector<std::byte> ktx2 = readFile(folder / "etc1s.ktx2"), texels = readFile(folder / "etc1s.rgba");
  GltfBuilder b = triangleFile();
  b.add("images", {{"uri", "nowhere.png"}});
  b.add("images", {{"bufferView", b.view(std::span<const std::byte>(ktx2))}, {"mimeType", "image/ktx2"}});
  b.add("textures", {{"source", 0}, {"extensions", {{"KHR_texture_basisu", {{"source", 1}}}}}});
  b.primitive()["material"] = b.add("materials", {{"emissiveTexture", {{"index", 0}}}});
  b.root["extensionsUsed"] = b.root["extensionsRequired"] = {"KHR_texture_basisu"};
  const Scene scene = b.load();
  ASSERT_EQ(scene.textures.at(0).bytes(), texels.size());
  EXPECT_EQ(std::memcmp(scene.textures[0].pixels.get(), texels.data(), texels.size()), 0);
}

#ifdef LATELIGHT_AVIF
// An AVIF image that ends after its type is decoded instead of the fallback.
TEST(GltfCompressed, AvifReplacesTheFallback) {
  const std::string type = std::string(3, 0) + "\x14" + "ftypavif" + std::string(4, 0) + "avif";
  GltfBuilder b = triangleFile();
  b.add("images", {{"uri", "nowhere.png"}});
  b.add("images", {{"bufferView", b.view(std::as_bytes(std::span(type)))}, {"mimeType", "image/avif"}});
  b.add("textures", {{"source", 0}, {"extensions", {{"EXT_texture_avif", {{"source", 1}}}}}});
  b.primitive()["material"] = b.add("materials", {{"emissiveTexture", {{"index", 0}}}});
  b.root["extensionsUsed"] = b.root["extensionsRequired"] = {"EXT_texture_avif"};
  EXPECT_THAT(errorOf(b), HasSubstr("is an invalid AVIF image"));
}
#endif

}  // namespace
}  // namespace latelight::scene::test
