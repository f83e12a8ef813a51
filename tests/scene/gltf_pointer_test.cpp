// KHR_animation_pointer and KHR_node_visibility: each kind of property by itself, compared with the closed form of its
// track.
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <functional>
#include <utility>

#include "base/log.h"
#include "gltf_builder.h"
#include "gltf_compressed_files.h"
#include "scene/edit.h"
#include "texture_pointers.h"

namespace latelight::scene::test {
namespace {

using testing::HasSubstr;

constexpr double kTime = 0.25;

// A triangle with a material, a light and a camera, each twice, with every property that pointers can target.
GltfBuilder sceneFile() {
  GltfBuilder b = triangleFile();
  const uint8_t pixel[] = {200, 100, 50};
  std::vector<uint8_t> tga = {0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0, 24, 0x20};
  tga.insert(tga.end(), pixel, pixel + 3);
  b.add("images", {{"bufferView", b.view(tga)}, {"mimeType", "image/png"}});
  b.add("textures", {{"source", 0}});
  const json moved = {{"index", 0},
                      {"extensions", {{"KHR_texture_transform", {{"offset", {.5, .25}}, {"scale", {2, 3}}}}}}};
  json material = {
      {"emissiveFactor", {.5, .25, .125}},
      {"extensions",
       {{"KHR_materials_emissive_strength", {{"emissiveStrength", 3}}}, {"KHR_materials_ior", {{"ior", 1.4}}}}}};
  for (const std::string& slot : kTexturePointers) material[json::json_pointer(slot)] = moved;
  b.primitive()["material"] = b.add("materials", material);
  b.root["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "spot"}, {"intensity", 2}, {"spot", json::object()}}};
  b.add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", .7}, {"znear", .1}, {"zfar", 10}}}});
  b.add("cameras",
        {{"type", "orthographic"}, {"orthographic", {{"xmag", 2}, {"ymag", 1}, {"znear", .1}, {"zfar", 10}}}});
  for (int i = 0; i < 2; ++i) b.node({{"camera", i}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  return b;
}

// Adds an animation of a pointer, linear from one value to the other within a second.
void animate(GltfBuilder& b, const std::string& pointer, std::vector<float> from, const std::vector<float>& to) {
  const char* types[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
  const size_t width = from.size();
  from.insert(from.end(), to.begin(), to.end());
  const int input = b.accessor(b.view(std::vector<float>{0, 1}), kFloat, "SCALAR", 2);
  const int output = b.accessor(b.view(from), kFloat, types[width], 2);
  b.add("animations",
        {{"channels",
          {{{"sampler", 0},
            {"target", {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", pointer}}}}}}}}}},
         {"samplers", {{{"input", input}, {"output", output}}}}});
}

struct At {
  explicit At(const Scene& scene, double seconds = kTime)
      : pose(poseAt(scene, choosePlayback(scene, "", false), seconds)), scene(scene) {}
  shared::Material material() const { return posedMaterials(scene, pose).at(0); }
  Light light(size_t i) const { return posedLights(scene, pose).at(i); }
  Camera camera(size_t i) const { return posedCameras(scene, pose).at(i); }
  Pose pose;
  const Scene& scene;
};

// From 0.2 to 0.6, the value after a quarter of a second is 0.3.
using Read = std::function<float(const At&)>;
void expectScalar(const std::string& pointer, const Read& read) {
  GltfBuilder b = sceneFile();
  animate(b, pointer, {.2f}, {.6f});
  const Scene scene = b.load();
  EXPECT_FLOAT_EQ(read(At(scene)), .3f) << pointer;
}

TEST(AnimationPointer, MovesScalarsOfMaterials) {
  expectScalar("/materials/0/pbrMetallicRoughness/metallicFactor", [](const At& at) { return at.material().metallic; });
  expectScalar("/materials/0/pbrMetallicRoughness/roughnessFactor",
               [](const At& at) { return at.material().roughness; });
  expectScalar("/materials/0/normalTexture/scale", [](const At& at) { return at.material().normalScale; });
  expectScalar("/materials/0/occlusionTexture/strength", [](const At& at) { return at.material().occlusionStrength; });
  expectScalar("/materials/0/alphaCutoff", [](const At& at) { return at.material().alphaCutoff; });
  expectScalar("/materials/0/extensions/KHR_materials_specular/specularFactor",
               [](const At& at) { return at.material().specular; });
  // 0.3 of the factor (0.5, 0.25, 0.125).
  expectScalar("/materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength",
               [](const At& at) { return at.material().emissive.y / .25f; });
}

// Properties of layers, too, all of which may have the value 0.3.
TEST(AnimationPointer, MovesScalarsOfLayers) {
  using Layers = shared::MaterialLayers;
  const std::pair<const char*, float Layers::*> all[] = {
      {"clearcoat/clearcoatFactor", &Layers::clearcoat},
      {"clearcoat/clearcoatRoughnessFactor", &Layers::clearcoatRoughness},
      {"clearcoat/clearcoatNormalTexture/scale", &Layers::clearcoatNormalScale},
      {"sheen/sheenRoughnessFactor", &Layers::sheenRoughness},
      {"anisotropy/anisotropyStrength", &Layers::anisotropy},
      {"anisotropy/anisotropyRotation", &Layers::anisotropyRotation},
      {"iridescence/iridescenceFactor", &Layers::iridescence},
      {"iridescence/iridescenceThicknessMinimum", &Layers::iridescenceThinnest},
      {"iridescence/iridescenceThicknessMaximum", &Layers::iridescenceThickest},
      {"transmission/transmissionFactor", &Layers::transmission},
      {"volume/thicknessFactor", &Layers::thickness},
      {"volume/attenuationDistance", &Layers::attenuationDistance},
      {"dispersion/dispersion", &Layers::dispersion},
      {"diffuse_transmission/diffuseTransmissionFactor", &Layers::diffuseTransmission}};
  for (const auto& [below, member] : all)
    expectScalar(std::string("/materials/0/extensions/KHR_materials_") + below,
                 [member = member](const At& at) { return at.material().layers.*member; });
}

// Beyond a property's range the value is clamped; an index of refraction is at least 1.
TEST(AnimationPointer, KeepsLayersInTheirRanges) {
  const auto layersOf = [](const char* below, std::vector<float> value) {
    GltfBuilder b = sceneFile();
    animate(b, std::string("/materials/0/extensions/KHR_materials_") + below, value, value);
    const Scene scene = b.load();
    return At(scene).material().layers;
  };
  EXPECT_EQ(layersOf("iridescence/iridescenceIor", {1.75f}).iridescenceIor, 1.75f);
  EXPECT_EQ(layersOf("iridescence/iridescenceIor", {.5f}).iridescenceIor, 1);
  EXPECT_EQ(layersOf("transmission/transmissionFactor", {1.5f}).transmission, 1);
  EXPECT_EQ(layersOf("dispersion/dispersion", {-1}).dispersion, 0);
  EXPECT_EQ(layersOf("clearcoat/clearcoatNormalTexture/scale", {-2}).clearcoatNormalScale, -2);
  // at which there would be no absorption
  EXPECT_GT(layersOf("volume/attenuationDistance", {0}).attenuationDistance, 0);
  EXPECT_EQ(layersOf("sheen/sheenColorFactor", {-1, .5f, 2}).sheenColor, vec3(0, .5f, 1));
}

TEST(AnimationPointer, MovesColors) {
  const auto colorOf = [](const std::string& pointer, std::vector<float> from, const std::vector<float>& to) {
    GltfBuilder b = sceneFile();
    animate(b, pointer, std::move(from), to);
    const Scene scene = b.load();
    return At(scene).material();
  };
  EXPECT_EQ(colorOf("/materials/0/pbrMetallicRoughness/baseColorFactor", {0, 0, 0, 1}, {1, .5, .25, 0}).baseColor,
            vec4(.25, .125, .0625, .75));
  // The file's strength is 3.
  EXPECT_EQ(colorOf("/materials/0/emissiveFactor", {0, 0, 0}, {1, .5, .25}).emissive, vec3(.75, .375, .1875));
  EXPECT_EQ(colorOf("/materials/0/extensions/KHR_materials_specular/specularColorFactor", {0, 0, 1}, {1, .5, 0})
                .specularColor,
            vec3(.25, .125, .75));
  const auto layersOf = [&](const char* below) {
    return colorOf(std::string("/materials/0/extensions/KHR_materials_") + below, {0, 0, 1}, {1, .5, 0}).layers;
  };
  EXPECT_EQ(layersOf("sheen/sheenColorFactor").sheenColor, vec3(.25, .125, .75));
  EXPECT_EQ(layersOf("volume/attenuationColor").attenuationColor, vec3(.25, .125, .75));
  EXPECT_EQ(layersOf("diffuse_transmission/diffuseTransmissionColorFactor").diffuseTransmissionColor,
            vec3(.25, .125, .75));
}

// The transform of every slot; parts that are not animated keep the file's values.
TEST(AnimationPointer, MovesTheTransformsOfAllTextures) {
  for (uint32_t slot = 0; slot < shared::kTextureCount; ++slot) {
    const std::string below = "/materials/0" + kTexturePointers[slot] + "/extensions/KHR_texture_transform/";
    GltfBuilder b = sceneFile();
    animate(b, below + "offset", {0, 0}, {1, 2});
    animate(b, below + "rotation", {0}, {float(2 * M_PI)});
    animate(b, below + "scale", {1, 1}, {5, 9});
    const Scene scene = b.load();
    const auto transformOf = [&](const char* animation) {
      const Pose pose = poseAt(scene, choosePlayback(scene, animation, false), kTime);
      return posedMaterials(scene, pose).at(0).transforms[slot];
    };
    EXPECT_EQ(transformOf("0").row0, vec3(2, 0, .25)) << kTexturePointers[slot];
    EXPECT_EQ(transformOf("0").row1, vec3(0, 3, .5));
    EXPECT_EQ(transformOf("2").row0, vec3(2, 0, .5));
    EXPECT_EQ(transformOf("2").row1, vec3(0, 3, .25));
    // A quarter turn: u runs along v, and v against u.
    const auto turned = transformOf("all");
    EXPECT_LT(glm::length(turned.row0 - vec3(0, 3, .25)), 1e-6f);
    EXPECT_LT(glm::length(turned.row1 - vec3(-2, 0, .5)), 1e-6f);
  }
}

TEST(AnimationPointer, MovesAllLightsMadeOfOne) {
  for (size_t i = 0; i < 2; ++i) {
    const std::string light = "/extensions/KHR_lights_punctual/lights/0/";
    expectScalar(light + "intensity", [&](const At& at) { return at.light(i).intensity; });
    expectScalar(light + "range", [&](const At& at) { return at.light(i).range.value(); });
    expectScalar(light + "spot/innerConeAngle", [&](const At& at) { return at.light(i).innerCone; });
    expectScalar(light + "spot/outerConeAngle", [&](const At& at) { return at.light(i).outerCone; });
  }
  GltfBuilder b = sceneFile();
  animate(b, "/extensions/KHR_lights_punctual/lights/0/color", {0, 0, 1}, {1, .5, 0});
  const Scene scene = b.load();
  EXPECT_EQ(At(scene).light(1).color, vec3(.25, .125, .75));
  EXPECT_EQ(posedLights(scene, {})[1].color, vec3(1));
}

TEST(AnimationPointer, MovesCameras) {
  expectScalar("/cameras/0/perspective/yfov", [](const At& at) { return at.camera(0).verticalFov; });
  expectScalar("/cameras/0/perspective/aspectRatio", [](const At& at) { return at.camera(0).aspect.value(); });
  expectScalar("/cameras/0/perspective/znear", [](const At& at) { return at.camera(0).nearClip; });
  expectScalar("/cameras/0/perspective/zfar", [](const At& at) { return at.camera(0).farClip; });
  expectScalar("/cameras/1/orthographic/xmag", [](const At& at) { return *at.camera(1).aspect * at.camera(1).yHalf; });
  expectScalar("/cameras/1/orthographic/ymag", [](const At& at) { return at.camera(1).yHalf; });
  expectScalar("/cameras/1/orthographic/znear", [](const At& at) { return at.camera(1).nearClip; });
  expectScalar("/cameras/1/orthographic/zfar", [](const At& at) { return at.camera(1).farClip; });
}

// Values that limit each other are limited when all are set, whatever the order of their channels.
TEST(AnimationPointer, TheOrderOfChannelsDoesNotMatter) {
  using Channel = std::pair<std::string, std::array<float, 2>>;
  const std::string light = "/extensions/KHR_lights_punctual/lights/0/spot/", camera = "/cameras/0/perspective/";
  const std::vector<Channel> channels = {{light + "innerConeAngle", {.9f, 1.1f}},
                                         {light + "outerConeAngle", {1, 1.4f}},
                                         {camera + "znear", {20, 24}},
                                         {camera + "zfar", {100, 140}}};
  for (const bool reversed : {false, true}) {
    SCOPED_TRACE(reversed);
    GltfBuilder b = sceneFile();
    for (size_t i = 0; i < channels.size(); ++i) {
      const auto& [pointer, values] = channels[reversed ? channels.size() - 1 - i : i];
      animate(b, pointer, {values[0]}, {values[1]});
    }
    const Scene scene = b.load();
    const Pose pose = poseAt(scene, choosePlayback(scene, "all", false), kTime);
    EXPECT_FLOAT_EQ(posedLights(scene, pose)[0].innerCone, .95f);
    EXPECT_FLOAT_EQ(posedLights(scene, pose)[0].outerCone, 1.1f);
    EXPECT_FLOAT_EQ(posedCameras(scene, pose)[0].nearClip, 21);
    EXPECT_FLOAT_EQ(posedCameras(scene, pose)[0].farClip, 110);
  }
}

TEST(AnimationPointer, CamerasKeepTheirPlanesIfTheAnimatedOnesAreImpossible) {
  GltfBuilder b = sceneFile();
  animate(b, "/cameras/0/perspective/znear", {20}, {24});  // beyond the far plane
  const Scene scene = b.load();
  EXPECT_FLOAT_EQ(At(scene).camera(0).nearClip, .1f);
  EXPECT_FLOAT_EQ(At(scene).camera(0).farClip, 10);
}

TEST(AnimationPointer, ColorsStayInTheirRange) {
  GltfBuilder b = sceneFile();
  animate(b, "/materials/0/pbrMetallicRoughness/baseColorFactor", {2, -1, .5f, 1}, {2, -1, .5f, 1});
  const Scene scene = b.load();
  EXPECT_EQ(At(scene).material().baseColor, vec4(1, 0, .5f, 1));
  GltfBuilder light = sceneFile();
  animate(light, "/extensions/KHR_lights_punctual/lights/0/color", {2, -1, .5f}, {2, -1, .5f});
  const Scene lit = light.load();
  EXPECT_EQ(At(lit).light(0).color, vec3(1, 0, .5f));
}

TEST(AnimationPointer, IndicesOfRefractionAreZeroOrAtLeastOne) {
  GltfBuilder b = sceneFile();
  animate(b, "/materials/0/extensions/KHR_materials_ior/ior", {-1}, {3});
  const Scene scene = b.load();
  EXPECT_EQ(At(scene, 0.25).material().f0, 1);         // 0, which stands for a reflectance of 1
  EXPECT_EQ(At(scene, 0.375).material().f0, 0);        // 0.5 becomes 1
  EXPECT_FLOAT_EQ(At(scene, 1).material().f0, 0.25f);  // ((3 - 1) / (3 + 1))^2
}

// An edit of the emission replaces both of its factors in the file.
TEST(AnimationPointer, ScalesTheEmissionOfAnEdit) {
  GltfBuilder b = sceneFile();
  animate(b, "/materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength", {2}, {6});
  Scene scene = b.load();
  Material edited = scene.materials[0];
  edited.data.emissive = {0, 1, 0};
  setMaterial(scene, 0, edited);
  EXPECT_EQ(At(scene).material().emissive, vec3(0, 3, 0));
}

TEST(AnimationPointer, MovesNodesAsOtherTracksDo) {
  GltfBuilder b = sceneFile();
  animate(b, "/nodes/0/translation", {0, 0, 0}, {4, 8, 0});
  animate(b, "/nodes/0/scale", {1, 1, 1}, {5, 9, 1});
  animate(b, "/nodes/0/rotation", {0, 0, 0, 1}, {0, 0, 1, 0});
  const Scene scene = b.load();
  const glm::dmat4 world = poseAt(scene, choosePlayback(scene, "all", false), kTime).world[0];
  EXPECT_EQ(world[3], glm::dvec4(1, 2, 0, 1));
  // Half a turn within a second, at an even speed.
  EXPECT_NEAR(world[0].x, 2 * std::sqrt(.5), 1e-9);
  EXPECT_NEAR(world[1].x, -3 * std::sqrt(.5), 1e-9);
}

TEST(AnimationPointer, MovesWeightsOfNodesAndMeshes) {
  for (const std::string pointer : {"/nodes/0/weights/1", "/meshes/0/weights/1"}) {
    GltfBuilder b = sceneFile();
    const int deltas = b.positions(std::vector<vec3>(3, vec3(1)));
    b.primitive()["targets"] = {{{"POSITION", deltas}}, {{"POSITION", deltas}}};
    b.root["meshes"][0]["weights"] = {.75, .5};
    animate(b, pointer, {.2f}, {.6f});
    const Scene scene = b.load();
    EXPECT_THAT(At(scene).pose.weights[0], testing::ElementsAre(.75f, testing::FloatEq(.3f))) << pointer;
    ASSERT_TRUE(scene.meshes[0].deformation);
  }
}

// --- visibility
// -------------------------------------------------------------------------------------------------------

json visible(bool value) {
  return {{"KHR_node_visibility", {{"visible", value}}}};
}

// A triangle below a node, and a light below the triangle's node.
GltfBuilder familyFile() {
  GltfBuilder b = triangleFile();
  b.root["nodes"][0] = {{"children", {1}}};
  b.add("nodes", {{"mesh", 0}, {"children", {2}}});
  b.root["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
  b.add("nodes", {{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  return b;
}

TEST(NodeVisibility, HidesWhatIsBelow) {
  GltfBuilder b = familyFile();
  EXPECT_TRUE(isShown(b.load(), {}, b.load().instances[0]));
  b.root["nodes"][0]["extensions"] = visible(false);
  b.root["nodes"][1]["extensions"] = visible(true);
  const Scene scene = b.load();
  EXPECT_FALSE(isShown(scene, {}, scene.instances[0]));
  EXPECT_TRUE(posedLights(scene, {})[0].removed);
  EXPECT_TRUE(worldBounds(scene).empty());
}

TEST(NodeVisibility, IsAnimated) {
  GltfBuilder b = familyFile();
  b.root["nodes"][1]["extensions"] = visible(false);
  const int input = b.accessor(b.view(std::vector<float>{1, 2}), kFloat, "SCALAR", 2);
  const int output = b.accessor(b.view(std::vector<uint8_t>{1, 0}), kUnsignedByte, "SCALAR", 2);
  const json pointer = {{"pointer", "/nodes/1/extensions/KHR_node_visibility/visible"}};
  b.add("animations",
        {{"channels",
          {{{"sampler", 0}, {"target", {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", pointer}}}}}}}},
         {"samplers", {{{"input", input}, {"output", output}, {"interpolation", "STEP"}}}}});
  const Scene scene = b.load();
  for (const auto& [seconds, shown] : {std::pair(0.5, true), {1.5, true}, {2.0, false}, {9.0, false}}) {
    const At at(scene, seconds);
    EXPECT_EQ(isShown(scene, at.pose, scene.instances[0]), shown) << seconds;
    EXPECT_EQ(at.light(0).removed, !shown) << seconds;
  }
  EXPECT_FALSE(isShown(scene, {}, scene.instances[0]));
  b.root["animations"][0]["samplers"][0].erase("interpolation");
  const Scene still = b.load();  // an inapplicable channel is skipped with a warning
  EXPECT_FALSE(isShown(still, {}, still.instances[0]));
}

// --- what is refused
// --------------------------------------------------------------------------------------------------

// One warning names the first of the materials.
TEST(AnimationPointer, UnsupportedPropertiesAreNamedOnce) {
  GltfBuilder b = sceneFile();
  for (int i = 0; i < 2; ++i) b.add("materials", {{"name", "other"}});
  for (const int material : {1, 0, 2}) animate(b, "/materials/" + std::to_string(material) + "/extras/wear", {0}, {1});
  testing::internal::CaptureStderr();
  b.load();
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "warning: the file animates /materials/1/extras/wear, which is not supported and keeps its value\n");
}

std::string pointerError(const std::string& pointer) {
  GltfBuilder b = sceneFile();
  animate(b, pointer, {.2f}, {.6f});
  return errorOf(b);
}

TEST(AnimationPointer, RefusesWhatIsNotThere) {
  EXPECT_THAT(pointerError("/nodes/7/translation"), HasSubstr("/nodes/7, but there are 3"));
  EXPECT_THAT(pointerError("/materials/1/alphaCutoff"), HasSubstr("there are 1"));
  EXPECT_THAT(pointerError("/cameras/2/perspective/yfov"), HasSubstr("there are 2"));
  EXPECT_THAT(pointerError("/extensions/KHR_lights_punctual/lights/1/intensity"), HasSubstr("there are 1"));
  EXPECT_THAT(pointerError("/nodes/0/weights/first"), HasSubstr("weights/first"));
  EXPECT_THAT(pointerError("nodes"), HasSubstr("slash"));
  EXPECT_THAT(pointerError("/nodes/0/translation"), HasSubstr("wrong number"));  // the number of components
}

// Loads a file whose animation has one channel with the pointer, and expects it to be skipped with this warning.
void expectSkipped(const std::string& pointer, const std::string& warning) {
  GltfBuilder b = sceneFile();
  animate(b, pointer, {.2f}, {.6f});
  std::vector<std::string> warnings;
  const WarningCapture capture(warnings);
  const Scene scene = b.load();
  EXPECT_THAT(warnings, testing::ElementsAre(HasSubstr(warning))) << pointer;
  EXPECT_TRUE(scene.rig.animations.at(0).tracks.empty()) << pointer;
  EXPECT_TRUE(scene.rig.animations.at(0).values.empty()) << pointer;
}

// Such channels are skipped as those with the path "weights" are.
TEST(AnimationPointer, SkipsWeightsOfMeshesWithoutMorphTargets) {
  for (const char* pointer :
       {"/nodes/0/weights/0", "/nodes/0/weights", "/nodes/1/weights/0", "/meshes/0/weights/0", "/meshes/0/weights"})
    expectSkipped(pointer, "whose mesh has no morph targets, and is left out");
}

TEST(AnimationPointer, SkipsPropertiesOfTheOtherProjection) {
  for (const std::string pointer : {"/cameras/1/perspective/yfov", "/cameras/1/perspective/znear",
                                    "/cameras/0/orthographic/ymag", "/cameras/0/orthographic/zfar"})
    expectSkipped(pointer, "the file animates " + pointer + ", which is not supported and keeps its value");
}

// A property that the file does not have is ignored, and the file loads.
TEST(AnimationPointer, LeavesOtherPropertiesAsTheyAre) {
  for (const char* pointer : {"/materials/0/extensions/KHR_materials_unknown/factor", "/asset/version", "/nodes",
                              "/nodes/0/extras/size", "/materials/0/doubleSided"}) {
    GltfBuilder b = sceneFile();
    animate(b, pointer, {.2f}, {.6f});
    const Scene scene = b.load();
    EXPECT_TRUE(At(scene).pose.values.empty()) << pointer;
  }
}

}  // namespace
}  // namespace latelight::scene::test
