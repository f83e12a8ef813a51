// The contents of glTF documents: the default values of the specification, and types that it does not define.
#include "scene/gltf/model.h"

#include <gmock/gmock.h>

#include <numbers>

#include "gltf_builder.h"

namespace latelight::scene::test {
namespace {

using testing::HasSubstr;

TEST(GltfModel, DefaultsOfMaterials) {
  const json root = {{"materials", {json::object()}}};
  const auto material = gltf::file::readModel(root).materials.at(0);
  EXPECT_EQ(material.metallicRoughness.baseColorFactor, vec4(1));
  EXPECT_EQ(material.metallicRoughness.metallicFactor, 1);
  EXPECT_EQ(material.metallicRoughness.roughnessFactor, 1);
  EXPECT_EQ(material.emissiveFactor, vec3(0));
  EXPECT_EQ(material.alphaMode, "OPAQUE");
  EXPECT_EQ(material.alphaCutoff, 0.5f);
  EXPECT_FALSE(material.doubleSided);
  EXPECT_EQ(material.normalScale, 1);
  EXPECT_EQ(material.occlusionStrength, 1);
  EXPECT_EQ(material.normalTexture.texture, -1);
  EXPECT_EQ(material.ior, 1.5f);
  EXPECT_EQ(material.specular.specularFactor, 1);
  EXPECT_EQ(material.specular.specularColorFactor, vec3(1));
  EXPECT_EQ(material.iridescence.iridescenceIor, 1.3f);
  EXPECT_EQ(material.iridescence.iridescenceThicknessMinimum, 100);
  EXPECT_EQ(material.iridescence.iridescenceThicknessMaximum, 400);
  EXPECT_EQ(material.volume.attenuationColor, vec3(1));
  EXPECT_FALSE(material.specularGlossiness);
}

TEST(GltfModel, DefaultsOfTheRest) {
  const json root = {
      {"samplers", {json::object()}},
      {"textures", {json::object()}},
      {"nodes", {json::object()}},
      {"meshes", {{{"primitives", {{{"attributes", json::object()}}}}}}},
      {"extensions", {{"KHR_lights_punctual", {{"lights", {{{"type", "spot"}, {"spot", json::object()}}}}}}}}};
  const gltf::file::Model model = gltf::file::readModel(root);
  EXPECT_EQ(model.samplers.at(0).wrapS, 10497);  // REPEAT
  EXPECT_EQ(model.samplers.at(0).wrapT, 10497);
  EXPECT_EQ(model.samplers.at(0).minFilter, -1);
  EXPECT_EQ(model.textures.at(0).image, -1);
  EXPECT_EQ(model.meshes.at(0).primitives.at(0).mode, 4);  // TRIANGLES
  EXPECT_EQ(model.meshes.at(0).primitives.at(0).material, -1);
  EXPECT_EQ(model.nodes.at(0).rotation, glm::dvec4(0, 0, 0, 1));
  EXPECT_EQ(model.nodes.at(0).scale, glm::dvec3(1));
  EXPECT_EQ(model.nodes.at(0).mesh, -1);
  EXPECT_TRUE(model.nodes.at(0).visible);
  EXPECT_EQ(model.scene, -1);
  EXPECT_EQ(model.lights.at(0).color, vec3(1));
  EXPECT_EQ(model.lights.at(0).intensity, 1);
  EXPECT_EQ(model.lights.at(0).innerConeAngle, 0);
  EXPECT_EQ(model.lights.at(0).outerConeAngle, std::numbers::pi / 4);
}

TEST(GltfModel, WholeNumbersBeyond32Bits) {
  const json volume = {{"thicknessFactor", 8589934592}};
  const json root = {{"materials", {{{"extensions", {{"KHR_materials_volume", volume}}}}}}};
  EXPECT_EQ(gltf::file::readModel(root).materials.at(0).volume.thicknessFactor, 0x1p33f);
}

TEST(GltfModel, TypesThatGltfDoesNotDefine) {
  GltfBuilder accessor = triangleFile(), stride = triangleFile();
  accessor.root["accessors"][1]["type"] = "VEC5";
  EXPECT_THAT(errorOf(accessor), HasSubstr("accessors[1].type is \"VEC5\""));
  stride.root["bufferViews"][1]["byteStride"] = 10;
  EXPECT_THAT(errorOf(stride), HasSubstr("bufferViews[1].byteStride is 10, which is not a multiple of 4"));

  GltfBuilder camera = triangleFile(), light = triangleFile();
  camera.add("cameras", {{"type", "fisheye"}});
  EXPECT_THAT(errorOf(camera), HasSubstr("cameras[0].type is \"fisheye\""));
  camera.root["cameras"][0]["type"] = "perspective";
  EXPECT_THAT(errorOf(camera), HasSubstr("cameras[0].perspective is missing"));
  light.root["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "spot"}}};
  EXPECT_THAT(errorOf(light), HasSubstr("lights[0].spot is missing"));
}

}  // namespace
}  // namespace latelight::scene::test
