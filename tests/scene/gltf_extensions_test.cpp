// The table of extensions compared with docs/gltf.md, and files that use all of them, with each of their fields
// damaged.
#include "scene/gltf/extensions.h"

#include <gmock/gmock.h>

#include <regex>
#include <set>

#include "base/files.h"
#include "base/log.h"
#include "gltf_builder.h"

namespace latelight::scene::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using Names = std::set<std::string>;

Names namesOf(Treatment treatment) {
  Names names;
  for (const Extension& extension : extensions())
    if (extension.treatment == treatment) names.emplace(extension.name);
  if (treatment == Treatment::Read) names.insert("EXT_texture_avif");  // depends on the libraries of the build
  if (treatment == Treatment::Left) names.erase("EXT_texture_avif");
  return names;
}

// The names in the section of a page that begins with a heading, up to the next heading.
Names namesInSection(const std::string& page, const std::string& heading) {
  const size_t begin = page.find("\n### " + heading + "\n");
  EXPECT_NE(begin, std::string::npos) << heading;
  const std::string section = page.substr(begin + 1, page.find("\n#", begin + 5) - begin);
  static const std::regex name("(^|\n)\\| `([A-Z]+_?[A-Za-z0-9_]*)` ");
  Names names;
  for (std::sregex_iterator i(section.begin(), section.end(), name), end; i != end; ++i) names.insert((*i)[2]);
  return names;
}

TEST(GltfExtensions, ThePageHasTheTable) {
  const std::vector<std::byte> bytes = readFile(fs::path(LATELIGHT_SOURCE_DIR) / "docs/gltf.md");
  const std::string page(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  EXPECT_EQ(namesInSection(page, "Read"), namesOf(Treatment::Read));
  EXPECT_EQ(namesInSection(page, "Ignored"), namesOf(Treatment::Ignored));
  EXPECT_EQ(namesInSection(page, "Not supported"), namesOf(Treatment::Left));
}

TEST(GltfExtensions, OnlyThoseThatAreReadMayBeRequired) {
  for (const Extension& extension : extensions()) {
    GltfBuilder b = triangleFile();
    b.root["extensionsUsed"] = b.root["extensionsRequired"] = {extension.name};
    if (extension.treatment == Treatment::Read)
      EXPECT_EQ(b.load().meshes.size(), 1u) << extension.name;
    else
      EXPECT_THAT(errorOf(b), HasSubstr(std::string(extension.name)));
  }
}

// --- a file with all extensions -------------------------------------------------------------------------------------

// Extensions with their own binary data instead of fields; gltf_compressed_test.cpp and gltf_fuzz_test.cpp damage
// those.
const Names kBytes = {"EXT_meshopt_compression", "KHR_draco_mesh_compression", "KHR_mesh_quantization"};

int addImage(GltfBuilder& b) {
  const std::vector<uint8_t> tga = {0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0, 32, 0x28, 3, 2, 1, 200};
  return b.add("images", {{"bufferView", b.view(tga)}});
}

void addLayers(GltfBuilder& b, const json& texture) {
  json normal = texture;
  normal["scale"] = .5;
  b.add("materials", {{"extensions",
                       {{"KHR_materials_clearcoat",
                         {{"clearcoatFactor", .5},
                          {"clearcoatTexture", texture},
                          {"clearcoatRoughnessFactor", .1},
                          {"clearcoatRoughnessTexture", texture},
                          {"clearcoatNormalTexture", normal}}},
                        {"KHR_materials_sheen",
                         {{"sheenColorFactor", {.1, .2, .3}},
                          {"sheenColorTexture", texture},
                          {"sheenRoughnessFactor", .5},
                          {"sheenRoughnessTexture", texture}}},
                        {"KHR_materials_anisotropy",
                         {{"anisotropyStrength", .5}, {"anisotropyRotation", .1}, {"anisotropyTexture", texture}}},
                        {"KHR_materials_iridescence",
                         {{"iridescenceFactor", .5},
                          {"iridescenceTexture", texture},
                          {"iridescenceIor", 1.4},
                          {"iridescenceThicknessMinimum", 200},
                          {"iridescenceThicknessMaximum", 300},
                          {"iridescenceThicknessTexture", texture}}}}}});
  b.add("materials", {{"extensions",
                       {{"KHR_materials_transmission", {{"transmissionFactor", .5}, {"transmissionTexture", texture}}},
                        {"KHR_materials_volume",
                         {{"thicknessFactor", .5},
                          {"thicknessTexture", texture},
                          {"attenuationDistance", 2},
                          {"attenuationColor", {.5, .6, .7}}}},
                        {"KHR_materials_dispersion", {{"dispersion", .5}}},
                        {"KHR_materials_diffuse_transmission",
                         {{"diffuseTransmissionFactor", .5},
                          {"diffuseTransmissionTexture", texture},
                          {"diffuseTransmissionColorFactor", {.5, .6, .7}},
                          {"diffuseTransmissionColorTexture", texture}}}}}});
}

void addMaterials(GltfBuilder& b) {
  const json texture = {
      {"index", 0},
      {"extensions",
       {{"KHR_texture_transform", {{"offset", {.1, .2}}, {"rotation", .3}, {"scale", {2, 3}}, {"texCoord", 1}}}}}};
  b.add("materials", {{"extensions",
                       {{"KHR_materials_emissive_strength", {{"emissiveStrength", 2}}},
                        {"KHR_materials_ior", {{"ior", 1.4}}},
                        {"KHR_materials_specular",
                         {{"specularFactor", .5},
                          {"specularColorFactor", {.5, .6, .7}},
                          {"specularTexture", texture},
                          {"specularColorTexture", texture}}},
                        {"KHR_materials_unlit", json::object()}}}});
  addLayers(b, texture);
  b.add("materials", {{"extensions",
                       {{"KHR_materials_pbrSpecularGlossiness",
                         {{"diffuseFactor", {.1, .2, .3, .4}},
                          {"diffuseTexture", texture},
                          {"specularFactor", {.1, .2, .3}},
                          {"glossinessFactor", .5},
                          {"specularGlossinessTexture", texture}}}}}});
}

void addLights(GltfBuilder& b) {
  b.root["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "spot"},
       {"color", {1, 1, 1}},
       {"intensity", 2},
       {"range", 3},
       {"spot", {{"innerConeAngle", .1}, {"outerConeAngle", .2}}}}};
  json light = {{"rotation", {0, 0, 0, 1}}, {"intensity", 2}, {"specularImageSize", 1}};
  light["specularImages"] = {{0, 0, 0, 0, 0, 0}};
  light["irradianceCoefficients"] = std::vector<std::vector<int>>(9, {1, 1, 1});
  b.root["extensions"]["EXT_lights_image_based"]["lights"] = {light};
  b.root["scenes"][0]["extensions"]["EXT_lights_image_based"]["light"] = 0;
}

GltfBuilder completeFile() {
  GltfBuilder b = triangleFile();
  const int image = addImage(b);
  json others;
  for (const char* name : {"EXT_texture_webp", "EXT_texture_avif", "KHR_texture_basisu"})
    others[name] = {{"source", image}};
  b.add("textures", {{"source", image}, {"extensions", others}});
  addMaterials(b);
  addLights(b);
  b.root["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "a"}}};
  b.primitive()["material"] = 0;
  b.primitive()["extensions"]["KHR_materials_variants"]["mappings"] = {{{"material", 1}, {"variants", {0}}}};
  b.node({{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}, {"KHR_node_visibility", {{"visible", false}}}}}});
  b.node(
      {{"mesh", 0},
       {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", b.positions({{1, 0, 0}})}}}}}}}});
  const int times = b.accessor(b.view(std::vector<float>{0, 1}), kFloat, "SCALAR", 2);
  const json pointer = {{"pointer", "/materials/0/alphaCutoff"}};
  b.add("animations",
        {{"channels",
          {{{"sampler", 0}, {"target", {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", pointer}}}}}}}},
         {"samplers", {{{"input", times}, {"output", times}}}}});
  for (const std::string& name : namesOf(Treatment::Read)) b.use(name.c_str());
  return b;
}

// JSON pointers to the fields within extensions, with their values.
std::map<std::string, json> fieldsOf(const GltfBuilder& b) {
  std::map<std::string, json> fields;
  const json flat = b.root.flatten();
  for (const auto& [pointer, value] : flat.items())
    if (pointer.find("/extensions/") != std::string::npos) fields[pointer] = value;
  return fields;
}

GltfBuilder withField(const GltfBuilder& b, const std::string& pointer, const json& value) {
  GltfBuilder changed = b;
  changed.root[json::json_pointer(pointer)] = value;
  return changed;
}

TEST(GltfExtensions, AFileCanUseThemAll) {
  const GltfBuilder b = completeFile();
  Names used = kBytes;
  for (const auto& [pointer, value] : fieldsOf(b))
    for (const Extension& extension : extensions())
      if (pointer.find(extension.name) != std::string::npos) used.emplace(extension.name);
  EXPECT_EQ(used, namesOf(Treatment::Read)) << "completeFile() lacks some";
  const Scene scene = b.load();
  EXPECT_TRUE(scene.environment);
  EXPECT_EQ(scene.rig.animations.at(0).values.size(), 1u);
}

TEST(GltfExtensions, FieldsOfAnotherTypeAreRefused) {
  const GltfBuilder b = completeFile();
  for (const auto& [pointer, value] : fieldsOf(b)) {
    const json other = value.is_string() ? json(5) : json("text");
    for (const json& wrong : {other, json(nullptr), json::array({json::object()})}) {
      if (value.is_object()) continue;  // an empty object, as for KHR_materials_unlit
      SCOPED_TRACE(pointer + " is " + wrong.dump());
      EXPECT_FALSE(errorOf(withField(b, pointer, wrong)).empty());
    }
  }
}

TEST(GltfExtensions, FieldsOutOfRangeAreReadOrRefused) {
  setQuiet(true);
  const GltfBuilder b = completeFile();
  for (const auto& [pointer, value] : fieldsOf(b)) {
    for (const json& odd :
         {json(-1), json(0), json(0.5), json(1e300), json(1e38), json(4294967295u), json(-2147483649)}) {
      SCOPED_TRACE(pointer + " is " + odd.dump());
      try {
        // The environment takes half a second to prepare.
        const Scene scene = withField(b, pointer, odd).load({.textures = false});
        posedMaterials(scene, poseAt(scene, choosePlayback(scene, "", false), 0.5));
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::BadInput) << error.what();
      }
    }
  }
  setQuiet(false);
}

TEST(GltfExtensions, IndicesOfNothingAreRefused) {
  const GltfBuilder b = completeFile();
  const std::regex index("/(index|source|light|material|node|TRANSLATION|variants/0|specularImages/0/[0-5])$");
  size_t count = 0;
  for (const auto& [pointer, value] : fieldsOf(b)) {
    if (!std::regex_search(pointer, index)) continue;
    ++count;
    for (const json& wrong : {json(-1), json(99), json(0.5)})
      EXPECT_FALSE(errorOf(withField(b, pointer, wrong)).empty()) << pointer;
  }
  EXPECT_GT(count, 15u);
}

}  // namespace
}  // namespace latelight::scene::test
