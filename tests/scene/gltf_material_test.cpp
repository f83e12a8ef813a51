// Materials, texture references and variants.
#include <gmock/gmock.h>

#include <cmath>

#include "base/log.h"
#include "gltf_builder.h"
#include "texture_pointers.h"

namespace latelight::scene::test {
namespace {

using testing::HasSubstr;
using namespace shared;

// A 1x1 image for every slot: a BMP of one pixel.
int addPicture(GltfBuilder& b) {
  std::vector<uint8_t> bmp = {'B', 'M', 58, 0, 0, 0, 0, 0, 0, 0, 54, 0, 0, 0,  40,
                              0,   0,   0,  1, 0, 0, 0, 1, 0, 0, 0,  1, 0, 24, 0};
  bmp.resize(54);
  bmp.insert(bmp.end(), {30, 20, 10, 0});
  return b.add("images", {{"bufferView", b.view(bmp)}});
}

GltfBuilder withMaterial(json material) {
  GltfBuilder b = triangleFile();
  addPicture(b);
  b.add("samplers", {{"magFilter", 9728}, {"minFilter", 9986}, {"wrapS", 33071}, {"wrapT", 33648}});
  b.add("textures", {{"source", 0}});
  b.add("textures", {{"source", 0}, {"sampler", 0}});
  b.primitive()["material"] = b.add("materials", std::move(material));
  return b;
}

TEST(GltfMaterial, DefaultsAreTheSpecifications) {
  Scene scene = triangleFile().load();
  ASSERT_EQ(scene.materials.size(), 1u);
  const auto& m = scene.materials[0].data;
  EXPECT_EQ(m.baseColor, vec4(1));
  EXPECT_EQ(m.emissive, vec3(0));
  EXPECT_EQ(m.metallic, 1);
  EXPECT_EQ(m.roughness, 1);
  EXPECT_FLOAT_EQ(m.f0, 0.04f);
  EXPECT_EQ(m.specular, 1);
  EXPECT_EQ(m.specularColor, vec3(1));
  EXPECT_EQ(m.flags, 0u);
  EXPECT_EQ(m.textures, 0u);
  EXPECT_EQ(m.transforms[3].row0, vec3(1, 0, 0));
  EXPECT_EQ(m.transforms[3].row1, vec3(0, 1, 0));
}

TEST(GltfMaterial, FactorsTexturesAndFlags) {
  GltfBuilder b = withMaterial({{"name", "paint"},
                                {"pbrMetallicRoughness",
                                 {{"baseColorFactor", {.1, .2, .3, .4}},
                                  {"metallicFactor", .5},
                                  {"roughnessFactor", .6},
                                  {"baseColorTexture", {{"index", 0}}},
                                  {"metallicRoughnessTexture", {{"index", 1}, {"texCoord", 1}}}}},
                                {"normalTexture", {{"index", 0}, {"scale", .7}}},
                                {"occlusionTexture", {{"index", 0}, {"strength", .8}}},
                                {"emissiveTexture", {{"index", 0}}},
                                {"emissiveFactor", {1, .5, .25}},
                                {"alphaMode", "MASK"},
                                {"alphaCutoff", .3},
                                {"doubleSided", true}});
  Scene scene = b.load();
  ASSERT_EQ(scene.materials.size(), 1u);  // no additional default material
  const scene::Material& material = scene.materials[0];
  EXPECT_EQ(material.name, "paint");
  EXPECT_EQ(material.data.baseColor, vec4(.1f, .2f, .3f, .4f));
  EXPECT_EQ(material.data.emissive, vec3(1, .5f, .25f));
  EXPECT_FLOAT_EQ(material.data.metallic, .5f);
  EXPECT_FLOAT_EQ(material.data.roughness, .6f);
  EXPECT_FLOAT_EQ(material.data.normalScale, .7f);
  EXPECT_FLOAT_EQ(material.data.occlusionStrength, .8f);
  EXPECT_FLOAT_EQ(material.data.alphaCutoff, .3f);
  EXPECT_EQ(material.data.flags, kMaterialMasked | kMaterialDoubleSided);
  EXPECT_EQ(material.data.textures, 0b11111u);
  EXPECT_EQ(material.data.transforms[kTextureMetallicRoughness].uvSet, 1u);
  // One image, used with two encodings.
  ASSERT_EQ(scene.textures.size(), 2u);
  int color = material.slots[kTextureBaseColor].texture, data = material.slots[kTextureNormal].texture;
  EXPECT_TRUE(scene.textures[size_t(color)].srgb);
  EXPECT_FALSE(scene.textures[size_t(data)].srgb);
  EXPECT_EQ(material.slots[kTextureEmissive].texture, color);
  EXPECT_EQ(material.slots[kTextureMetallicRoughness].texture, data);
  EXPECT_EQ(material.slots[kTextureOcclusion].texture, data);
  EXPECT_EQ(scene.textures[size_t(color)].pixels[0], std::byte{10});
  Sampler odd{Wrap::Clamp, Wrap::Mirror, Filter::Nearest, Filter::Nearest, MipFilter::Linear};
  EXPECT_EQ(material.slots[kTextureMetallicRoughness].sampler, odd);
  EXPECT_EQ(material.slots[kTextureBaseColor].sampler, Sampler());
}

TEST(GltfMaterial, EveryMinificationFilter) {
  struct Case {
    int gl;
    Filter filter;
    MipFilter mip;
  };
  for (Case c : {Case{9728, Filter::Nearest, MipFilter::None},
                 {9729, Filter::Linear, MipFilter::None},
                 {9984, Filter::Nearest, MipFilter::Nearest},
                 {9985, Filter::Linear, MipFilter::Nearest},
                 {9986, Filter::Nearest, MipFilter::Linear},
                 {9987, Filter::Linear, MipFilter::Linear}}) {
    GltfBuilder b = withMaterial({{"normalTexture", {{"index", 1}}}});
    b.root["samplers"][0] = {{"minFilter", c.gl}};
    Sampler sampler = b.load().materials[0].slots[kTextureNormal].sampler;
    EXPECT_EQ(sampler.minify, c.filter) << c.gl;
    EXPECT_EQ(sampler.mip, c.mip) << c.gl;
  }
}

TEST(GltfMaterial, BlendIsNoMask) {
  const auto data = withMaterial({{"alphaMode", "BLEND"}, {"alphaCutoff", .1}}).load().materials[0].data;
  EXPECT_EQ(data.flags, kMaterialBlended);
  EXPECT_EQ(data.alphaCutoff, .5f);
}

TEST(GltfMaterial, Extensions) {
  Scene scene = withMaterial({{"emissiveFactor", {1, 1, .5}},
                              {"extensions",
                               {{"KHR_materials_unlit", json::object()},
                                {"KHR_materials_emissive_strength", {{"emissiveStrength", 8}}},
                                {"KHR_materials_ior", {{"ior", 1.8}}},
                                {"KHR_materials_specular",
                                 {{"specularFactor", .25},
                                  {"specularColorFactor", {2, .5, 0}},
                                  {"specularTexture", {{"index", 0}}},
                                  {"specularColorTexture", {{"index", 0}, {"texCoord", 1}}}}}}}})
                    .load();
  const scene::Material& material = scene.materials[0];
  EXPECT_EQ(material.data.flags, kMaterialUnlit);
  EXPECT_EQ(material.data.emissive, vec3(8, 8, 4));
  EXPECT_FLOAT_EQ(material.data.f0, .8f * .8f / (2.8f * 2.8f));
  EXPECT_EQ(material.data.specular, .25f);
  EXPECT_EQ(material.data.specularColor, vec3(2, .5f, 0));
  EXPECT_EQ(material.data.textures, 1u << kTextureSpecular | 1u << kTextureSpecularColor);
  EXPECT_FALSE(scene.textures[size_t(material.slots[kTextureSpecular].texture)].srgb);
  EXPECT_TRUE(scene.textures[size_t(material.slots[kTextureSpecularColor].texture)].srgb);
  EXPECT_EQ(material.data.transforms[kTextureSpecularColor].uvSet, 1u);
  json ior = {{"extensions", {{"KHR_materials_ior", {{"ior", 0}}}}}};
  EXPECT_EQ(withMaterial(ior).load().materials[0].data.f0, 1);
}

// Every texture of the layered extensions: its slot, whether it contains colors, and its own transform and texture
// coordinate set.
TEST(GltfMaterial, LayersHaveTextures) {
  struct Slot {
    const char *extension, *key;
    uint32_t slot;
    bool srgb;
  };
  const Slot slots[] = {
      {"KHR_materials_clearcoat", "clearcoatTexture", kTextureClearcoat, false},
      {"KHR_materials_clearcoat", "clearcoatRoughnessTexture", kTextureClearcoatRoughness, false},
      {"KHR_materials_clearcoat", "clearcoatNormalTexture", kTextureClearcoatNormal, false},
      {"KHR_materials_sheen", "sheenColorTexture", kTextureSheenColor, true},
      {"KHR_materials_sheen", "sheenRoughnessTexture", kTextureSheenRoughness, false},
      {"KHR_materials_anisotropy", "anisotropyTexture", kTextureAnisotropy, false},
      {"KHR_materials_iridescence", "iridescenceTexture", kTextureIridescence, false},
      {"KHR_materials_iridescence", "iridescenceThicknessTexture", kTextureIridescenceThickness, false},
      {"KHR_materials_transmission", "transmissionTexture", kTextureTransmission, false},
      {"KHR_materials_volume", "thicknessTexture", kTextureThickness, false},
      {"KHR_materials_diffuse_transmission", "diffuseTransmissionTexture", kTextureDiffuseTransmission, false},
      {"KHR_materials_diffuse_transmission", "diffuseTransmissionColorTexture", kTextureDiffuseTransmissionColor, true},
  };
  for (const Slot& s : slots) {
    const json info = {
        {"index", 1}, {"texCoord", 1}, {"extensions", {{"KHR_texture_transform", {{"offset", {.25, .5}}}}}}};
    const Scene scene = withMaterial({{"extensions", {{s.extension, {{s.key, info}}}}}}).load();
    const scene::Material& m = scene.materials[0];
    EXPECT_EQ(m.data.textures, 1u << s.slot) << s.key;
    ASSERT_GE(m.slots[s.slot].texture, 0) << s.key;
    EXPECT_EQ(scene.textures[size_t(m.slots[s.slot].texture)].srgb, s.srgb) << s.key;
    EXPECT_EQ(m.slots[s.slot].sampler.wrapU, Wrap::Clamp) << s.key;
    EXPECT_EQ(m.data.transforms[s.slot].uvSet, 1u) << s.key;
    EXPECT_EQ(m.data.transforms[s.slot].row0, vec3(1, 0, .25f)) << s.key;
    EXPECT_EQ(m.data.transforms[s.slot].row1, vec3(0, 1, .5f)) << s.key;
  }
}

TEST(GltfMaterial, LayersHaveFactors) {
  const json extensions = {
      {"KHR_materials_clearcoat",
       {{"clearcoatFactor", .5},
        {"clearcoatRoughnessFactor", .25},
        {"clearcoatNormalTexture", {{"index", 0}, {"scale", 2}}}}},
      {"KHR_materials_sheen", {{"sheenColorFactor", {.25, .5, .75}}, {"sheenRoughnessFactor", .5}}},
      {"KHR_materials_anisotropy", {{"anisotropyStrength", .5}, {"anisotropyRotation", 1.5}}},
      {"KHR_materials_iridescence",
       {{"iridescenceFactor", 1},
        {"iridescenceIor", 1.5},
        {"iridescenceThicknessMinimum", 50},
        {"iridescenceThicknessMaximum", 500}}},
      {"KHR_materials_transmission", {{"transmissionFactor", .75}}},
      {"KHR_materials_volume",
       {{"thicknessFactor", 2}, {"attenuationDistance", 4}, {"attenuationColor", {.5, 1, .25}}}},
      {"KHR_materials_dispersion", {{"dispersion", 3}}},
      {"KHR_materials_diffuse_transmission",
       {{"diffuseTransmissionFactor", .125}, {"diffuseTransmissionColorFactor", {1, .5, 0}}}}};
  const MaterialLayers l = withMaterial({{"extensions", extensions}}).load().materials[0].data.layers;
  EXPECT_EQ(l.clearcoat, .5f);
  EXPECT_EQ(l.clearcoatRoughness, .25f);
  EXPECT_EQ(l.clearcoatNormalScale, 2);
  EXPECT_EQ(l.sheenColor, vec3(.25f, .5f, .75f));
  EXPECT_EQ(l.sheenRoughness, .5f);
  EXPECT_EQ(l.anisotropy, .5f);
  EXPECT_EQ(l.anisotropyRotation, 1.5f);
  EXPECT_EQ(l.iridescence, 1);
  EXPECT_EQ(l.iridescenceIor, 1.5f);
  EXPECT_EQ(l.iridescenceThinnest, 50);
  EXPECT_EQ(l.iridescenceThickest, 500);
  EXPECT_EQ(l.transmission, .75f);
  EXPECT_EQ(l.thickness, 2);
  EXPECT_EQ(l.attenuationDistance, 4);
  EXPECT_EQ(l.attenuationColor, vec3(.5f, 1, .25f));
  EXPECT_EQ(l.dispersion, 3);
  EXPECT_EQ(l.diffuseTransmission, .125f);
  EXPECT_EQ(l.diffuseTransmissionColor, vec3(1, .5f, 0));
}

// They are clamped to their ranges, with a warning; only values that are not numbers are errors.
TEST(GltfMaterial, LayersOutOfRange) {
  const auto material = [](const char* extension, const char* key, json value) {
    return withMaterial({{"extensions", {{extension, {{key, std::move(value)}}}}}});
  };
  const auto error = [&](const char* extension, const char* key, json value) {
    return errorOf(material(extension, key, std::move(value)));
  };
  const auto layers = [&](const char* extension, const char* key, json value, const char* warning) {
    testing::internal::CaptureStderr();
    const shared::MaterialLayers read = material(extension, key, std::move(value)).load().materials.at(0).data.layers;
    EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr(warning));
    return read;
  };
  EXPECT_EQ(layers("KHR_materials_clearcoat", "clearcoatFactor", 1.5, "clearcoatFactor is 1.5").clearcoat, 1);
  EXPECT_EQ(layers("KHR_materials_sheen", "sheenColorFactor", {0, 2, 0}, "sheenColorFactor[1] is 2").sheenColor,
            vec3(0, 1, 0));
  EXPECT_EQ(layers("KHR_materials_iridescence", "iridescenceIor", .5, "iridescenceIor is 0.5").iridescenceIor, 1);
  EXPECT_EQ(layers("KHR_materials_volume", "attenuationDistance", 0, "attenuationDistance is 0").attenuationDistance, 0)
      << "as without one: the medium absorbs nothing";
  EXPECT_EQ(layers("KHR_materials_dispersion", "dispersion", -1, "dispersion is -1").dispersion, 0);
  EXPECT_THAT(error("KHR_materials_transmission", "transmissionFactor", "much"), HasSubstr("should be a number"));
  EXPECT_THAT(error("KHR_materials_anisotropy", "anisotropyTexture", {{"index", 7}}), HasSubstr("index is 7"));
}

TEST(GltfMaterial, FactorsOutOfRange) {
  GltfBuilder b = withMaterial(
      {{"pbrMetallicRoughness", {{"baseColorFactor", {2, -1, .5, 1}}, {"metallicFactor", 2}, {"roughnessFactor", -1}}},
       {"emissiveFactor", {-1, 2, 0}},
       {"alphaMode", "MASK"},
       {"alphaCutoff", -1},
       {"extensions", {{"KHR_materials_specular", {{"specularFactor", 3}, {"specularColorFactor", {-1, 2, 1}}}}}}});
  testing::internal::CaptureStderr();
  const shared::Material m = b.load().materials.at(0).data;
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("baseColorFactor[0] is 2"));
  EXPECT_EQ(m.baseColor, vec4(1, 0, .5f, 1));
  EXPECT_EQ(m.metallic, 1);
  EXPECT_EQ(m.roughness, 0);
  EXPECT_EQ(m.emissive, vec3(0, 2, 0)) << "files of exporters without KHR_materials_emissive_strength exceed 1";
  EXPECT_EQ(m.alphaCutoff, 0);
  EXPECT_EQ(m.specular, 1);
  EXPECT_EQ(m.specularColor, vec3(0, 2, 1));
}

// KHR_materials_ior allows 0, for a reflectance of 1, and values of at least 1.
TEST(GltfMaterial, IndicesOfRefractionOutOfRange) {
  const auto f0Of = [](double ior, const std::string& warning) {
    GltfBuilder b = withMaterial({{"extensions", {{"KHR_materials_ior", {{"ior", ior}}}}}});
    std::vector<std::string> warnings;
    const WarningCapture capture(warnings);
    const float f0 = b.load().materials.at(0).data.f0;
    EXPECT_EQ(warnings.size(), warning.empty() ? 0 : 1) << ior;
    if (!warnings.empty()) {
      EXPECT_THAT(warnings[0], HasSubstr(warning));
    }
    return f0;
  };
  EXPECT_EQ(f0Of(0, ""), 1);
  EXPECT_EQ(f0Of(1, ""), 0);
  EXPECT_FLOAT_EQ(f0Of(3, ""), .25f);
  EXPECT_EQ(f0Of(.5, "KHR_materials_ior.ior is 0.5, which is out of range: it is read as 1"), 0);
  EXPECT_EQ(f0Of(-2, "KHR_materials_ior.ior is -2.0, which is out of range: it is read as 0"), 1);
}

TEST(GltfMaterial, TextureTransform) {
  // KHR_texture_transform's own test model: the sign "correct" is at this texture coordinate of the panel that is
  // rotated by 22.5 degrees, and the arrow's tip in the image is at 0.5 + 0.2778.
  GltfBuilder b = withMaterial(
      {{"normalTexture",
        {{"index", 0}, {"extensions", {{"KHR_texture_transform", {{"rotation", 0.39269908169872414}}}}}}}});
  TextureTransform t = b.load().materials[0].data.transforms[kTextureNormal];
  vec3 sign(0.5f - 0.07904822f, 0.5f + 0.51626749f, 1);
  EXPECT_NEAR(glm::dot(t.row0, sign), 0.77781746f, 1e-6f);
  EXPECT_NEAR(glm::dot(t.row1, sign), 0.77781746f, 1e-6f);

  b.root["materials"][0]["normalTexture"]["extensions"]["KHR_texture_transform"] = {
      {"offset", {.5, .25}}, {"rotation", std::acos(0.0)}, {"scale", {2, 3}}, {"texCoord", 1}};
  t = b.load().materials[0].data.transforms[kTextureNormal];
  expectNear(t.row0, vec3(0, 3, .5f));  // scale first, then rotation, then offset
  expectNear(t.row1, vec3(-2, 0, .25f));
  EXPECT_EQ(t.uvSet, 1u);
}

// Each slot by itself, so that none uses another's.
TEST(GltfMaterial, EverySlotHasItsOwnTransformAndUvSet) {
  for (const bool inTransform : {false, true}) {
    json material;
    for (uint32_t slot = 0; slot < kTextureCount; ++slot) {
      json transform = {{"offset", {slot, slot + .5}}, {"scale", {slot + 1, 2}}};
      if (inTransform) transform["texCoord"] = slot % 2;
      material[json::json_pointer(kTexturePointers[slot])] = {{"index", 0},
                                                              {"texCoord", inTransform ? 1 - slot % 2 : slot % 2},
                                                              {"extensions", {{"KHR_texture_transform", transform}}}};
    }
    const Material read = withMaterial(material).load().materials[0];
    for (uint32_t slot = 0; slot < kTextureCount; ++slot) {
      EXPECT_EQ(read.data.transforms[slot].row0, vec3(slot + 1, 0, slot)) << kTexturePointers[slot];
      EXPECT_EQ(read.data.transforms[slot].row1, vec3(0, 2, slot + .5)) << kTexturePointers[slot];
      EXPECT_EQ(read.data.transforms[slot].uvSet, slot % 2) << kTexturePointers[slot];
    }
    EXPECT_EQ(read.data.textures, (1u << kTextureCount) - 1);
  }
}

TEST(GltfMaterial, UvSetsAboveTheSecondBecomeTheSecond) {
  EXPECT_EQ(withMaterial({{"normalTexture", {{"index", 0}, {"texCoord", 3}}}})
                .load()
                .materials[0]
                .data.transforms[kTextureNormal]
                .uvSet,
            1u);
}

// Textures then have the first set in all meshes, also in those with colors.
TEST(GltfMaterial, FirstUvSetReplacesAMissingSecondOne) {
  for (const bool hasColors : {false, true}) {
    GltfBuilder b = withMaterial({{"name", "rust"}, {"normalTexture", {{"index", 0}, {"texCoord", 1}}}});
    const std::vector<vec2> uv = {{.1f, .2f}, {.3f, .4f}, {.5f, .6f}};
    b.primitive()["attributes"]["TEXCOORD_0"] = b.vectors(uv);
    if (hasColors) b.primitive()["attributes"]["COLOR_0"] = b.vectors(std::vector<vec3>(3, vec3(.5f)));
    b.root["meshes"][0]["primitives"].push_back(json(b.primitive()));  // the warning is one per material
    std::vector<std::string> warnings;
    const WarningCapture capture(warnings);
    const Scene scene = b.load();
    EXPECT_THAT(
        warnings,
        testing::ElementsAre(HasSubstr("meshes[0].primitives[0] has no TEXCOORD_1, which the material \"rust\" uses")));
    ASSERT_EQ(scene.meshes[0].extras.size(), 3u);
    for (size_t i = 0; i < 3; ++i) EXPECT_EQ(scene.meshes[0].extras[i].uv1, uv[i]);
    EXPECT_NE(scene.meshes[0].attributes[0].tangent, vec4(0));
  }
}

TEST(GltfMaterial, SecondUvSet) {
  GltfBuilder b = triangleFile();
  b.primitive()["attributes"]["TEXCOORD_1"] = b.vectors(std::vector<vec2>{{.1f, .2f}, {.3f, .4f}, {.5f, .6f}});
  Scene scene = b.load();
  ASSERT_EQ(scene.meshes[0].extras.size(), 3u);
  EXPECT_EQ(scene.meshes[0].extras[2].uv1, vec2(.5f, .6f));
  EXPECT_EQ(scene.meshes[0].extras[2].color, vec4(1));
}

GltfBuilder withVariants() {
  GltfBuilder b = triangleFile();
  for (const char* name : {"plain", "red", "blue"}) b.add("materials", {{"name", name}});
  b.root["extensions"]["KHR_materials_variants"]["variants"] = {
      {{"name", "Red"}}, {{"name", "Blue"}}, {{"name", "Unmapped"}}};
  b.primitive()["material"] = 0;
  b.primitive()["extensions"]["KHR_materials_variants"]["mappings"] = {{{"material", 1}, {"variants", {0}}},
                                                                       {{"material", 2}, {"variants", {1}}}};
  return b;
}

// --- KHR_materials_pbrSpecularGlossiness -----------------------------------------------------------------------------

// A TGA of a row of texels, as RGBA.
int addRow(GltfBuilder& b, const std::vector<std::array<uint8_t, 4>>& texels) {
  std::vector<uint8_t> tga = {0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, uint8_t(texels.size()), 0, 1, 0, 32, 0x28};
  for (const auto& t : texels) tga.insert(tga.end(), {t[2], t[1], t[0], t[3]});
  const int image = b.add("images", {{"bufferView", b.view(tga)}});
  return b.add("textures", {{"source", image}});
}

json glossy(json factors) {
  return {{"pbrMetallicRoughness", {{"metallicFactor", .5}, {"baseColorFactor", {.9, .9, .9, 1}}}},
          {"extensions", {{"KHR_materials_pbrSpecularGlossiness", std::move(factors)}}}};
}

double linear(double srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

// c_diff = diffuse (1 - max(specular)), F0 = specular, alpha = (1 - glossiness)^2, as in the extension.
TEST(GltfMaterial, SpecularGlossinessFactors) {
  const GltfBuilder b = withMaterial(
      glossy({{"diffuseFactor", {.5, .25, 1, .75}}, {"specularFactor", {.25, .5, .125}}, {"glossinessFactor", .7}}));
  const shared::Material m = b.load().materials[0].data;
  EXPECT_EQ(m.baseColor, vec4(.25, .125, .5, .75));
  EXPECT_EQ(m.metallic, 0);
  EXPECT_FLOAT_EQ(m.roughness, .3f);
  EXPECT_EQ(m.f0 * m.specularColor * m.specular, vec3(.25, .5, .125));
  const shared::Material defaults = withMaterial(glossy(json::object())).load().materials[0].data;
  EXPECT_EQ(defaults.baseColor, vec4(0, 0, 0, 1));  // white specular leaves no diffuse part
  EXPECT_EQ(defaults.roughness, 0);
}

// Each texel is the nearest 8-bit value, computed from the file's own numbers.
TEST(GltfMaterial, SpecularGlossinessTextures) {
  GltfBuilder b = withMaterial({});
  const std::array<uint8_t, 4> diffuse[2] = {{200, 100, 0, 128}, {255, 255, 255, 255}};
  const std::array<uint8_t, 4> specular[2] = {{128, 64, 255, 51}, {10, 250, 90, 255}};
  const int color = addRow(b, {diffuse[0], diffuse[1]}), gloss = addRow(b, {specular[0], specular[1]});
  b.root["materials"][0] = glossy({{"diffuseTexture", {{"index", color}}},
                                   {"specularFactor", {.5, .5, .25}},
                                   {"glossinessFactor", .5},
                                   {"specularGlossinessTexture", {{"index", gloss}}}});
  const Scene scene = b.load();
  const Material& material = scene.materials[0];
  const auto texelsOf = [&](uint32_t slot) {
    const Texture& texture = scene.textures.at(size_t(material.slots[slot].texture));
    EXPECT_EQ(texture.width, 2u);
    return reinterpret_cast<const uint8_t*>(texture.pixels.get());
  };
  EXPECT_EQ(material.data.roughness, 1);
  EXPECT_EQ(material.data.specularColor, vec3(.5, .5, .25));
  EXPECT_EQ(std::memcmp(texelsOf(kTextureSpecularColor), specular, 8), 0);
  const double factor[3] = {.5, .5, .25};
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(texelsOf(kTextureMetallicRoughness)[4 * i + 1], std::lround(255 - .5 * specular[i][3]));
    double most = 0;
    for (size_t c = 0; c < 3; ++c) most = std::max(most, factor[c] * linear(specular[i][c] / 255.0));
    for (size_t c = 0; c < 3; ++c) {
      const double left = linear(texelsOf(kTextureBaseColor)[4 * i + c] / 255.0);
      const double expected = linear(diffuse[i][c] / 255.0) * (1 - most);
      EXPECT_NEAR(left, expected, 0.0045) << i << ' ' << c;  // half a step of sRGB where it is widest
    }
    EXPECT_EQ(texelsOf(kTextureBaseColor)[4 * i + 3], diffuse[i][3]);
  }
}

TEST(GltfMaterial, SpecularGlossinessWithOneTexture) {
  GltfBuilder b = withMaterial({});
  const int gloss = addRow(b, {{255, 255, 255, 0}, {0, 0, 0, 255}});
  b.root["materials"][0] = glossy({{"specularGlossinessTexture", {{"index", gloss}, {"texCoord", 1}}}});
  Scene scene = b.load();
  const Material& material = scene.materials[0];
  const Texture& base = scene.textures.at(size_t(material.slots[kTextureBaseColor].texture));
  EXPECT_EQ(uint8_t(base.pixels[0]), 0);
  EXPECT_EQ(uint8_t(base.pixels[4]), 255);
  EXPECT_EQ(material.data.transforms[kTextureBaseColor].uvSet, 1u);
  // A diffuse texture without another one is used unchanged as the base color.
  b.root["materials"][0] = glossy({{"diffuseTexture", {{"index", gloss}}}, {"specularFactor", {.5, 0, 0}}});
  scene = b.load();
  EXPECT_EQ(scene.textures.size(), 1u);
  EXPECT_EQ(scene.materials[0].data.baseColor, vec4(.5, .5, .5, 1));
}

TEST(GltfMaterial, Variants) {
  auto shown = [](const char* variant) {
    Scene scene = withVariants().load({.variant = variant});
    EXPECT_THAT(scene.variants, testing::ElementsAre("Red", "Blue", "Unmapped"));
    return scene.materials[scene.instances[0].material].name;
  };
  EXPECT_EQ(shown(""), "plain");
  EXPECT_EQ(shown("Red"), "red");
  EXPECT_EQ(shown("Blue"), "blue");
  EXPECT_EQ(shown("Unmapped"), "plain");
  EXPECT_THAT(errorOf(withVariants(), ExitCode::Usage, {.variant = "Green"}),
              HasSubstr("the file has Red, Blue, Unmapped"));
  EXPECT_THAT(errorOf(triangleFile(), ExitCode::Usage, {.variant = "Green"}), HasSubstr("no material variants"));
}

TEST(GltfMaterial, WrongIndicesAndValues) {
  EXPECT_THAT(errorOf(withMaterial({{"normalTexture", {{"index", 7}}}})),
              HasSubstr("materials[0].normalTexture.index is 7, but there are 2 textures"));
  EXPECT_THAT(errorOf(withMaterial({{"alphaMode", "GLASS"}})), HasSubstr("GLASS"));
  EXPECT_THAT(errorOf(withMaterial({{"emissiveFactor", {1, 2}}})),
              HasSubstr("materials[0].emissiveFactor has 2 items"));
}

}  // namespace
}  // namespace latelight::scene::test
