// Animations, skins and morph targets: the resulting positions of nodes and vertices, and the files that are rejected.
#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "gltf_compressed_files.h"

namespace latelight::scene::test {
namespace {

using glm::dvec3;
using testing::HasSubstr;

// A triangle whose node has one animated property; `values` is the accessor of the output.
GltfBuilder animated(const char* path, const std::vector<float>& times, const char* interpolation,
                     const std::function<int(GltfBuilder&)>& values) {
  GltfBuilder b = triangleFile();
  const int input = b.accessor(b.view(times), kFloat, "SCALAR", times.size()), output = values(b);
  b.add("animations", {{"name", "move"},
                       {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", path}}}}}},
                       {"samplers", {{{"input", input}, {"output", output}, {"interpolation", interpolation}}}}});
  return b;
}

// The node's transform, in the file's frame.
glm::dmat4 nodeAt(const Scene& scene, double seconds, bool loop = false) {
  return poseAt(scene, choosePlayback(scene, "", loop), seconds).world[0];
}
dvec3 placeAt(const Scene& scene, double seconds, bool loop = false) {
  return dvec3(nodeAt(scene, seconds, loop)[3]);
}

TEST(Animation, StepsHoldAndLinesGoStraight) {
  const auto positions = [](GltfBuilder& b) { return b.positions({{0, 0, 0}, {4, 0, 0}, {4, 2, 0}}); };
  const Scene step = animated("translation", {1, 2, 4}, "STEP", positions).load();
  EXPECT_EQ(placeAt(step, 1.999), dvec3(0, 0, 0));
  EXPECT_EQ(placeAt(step, 2), dvec3(4, 0, 0));
  const Scene line = animated("translation", {1, 2, 4}, "LINEAR", positions).load();
  EXPECT_EQ(placeAt(line, 1.25), dvec3(1, 0, 0));
  EXPECT_EQ(placeAt(line, 3), dvec3(4, 1, 0));
  EXPECT_FLOAT_EQ(duration(line, choosePlayback(line, "move", false)), 4);
}

TEST(Animation, FramesReachTheKeysThatFilesRoundFromTheirTimes) {
  for (const int rate : {24, 25, 30, 60}) {
    std::vector<float> times;
    std::vector<vec3> places;
    for (int i = 0; i < 48; ++i) {
      times.push_back(static_cast<float>(double(i) / rate));
      places.emplace_back(i, 0, 0);
    }
    const auto positions = [&](GltfBuilder& b) { return b.positions(places); };
    const Scene step = animated("translation", times, "STEP", positions).load();
    const Scene line = animated("translation", times, "LINEAR", positions).load();
    for (int i = 0; i < 48; ++i) {
      EXPECT_EQ(placeAt(step, double(i) / rate).x, i) << rate;
      EXPECT_NEAR(placeAt(line, double(i) / rate).x, i, 1e-4) << rate;
    }
  }
}

TEST(Animation, EndsHoldOrBeginAgain) {
  const Scene scene = animated("translation", {0, 2}, "LINEAR", [](GltfBuilder& b) {
                        return b.positions({{0, 0, 0}, {2, 0, 0}});
                      }).load();
  EXPECT_EQ(placeAt(scene, -5), dvec3(0));
  EXPECT_EQ(placeAt(scene, 1e6), dvec3(2, 0, 0));
  EXPECT_EQ(placeAt(scene, 2.5, true), dvec3(0.5, 0, 0));
  EXPECT_EQ(placeAt(scene, -0.5, true), dvec3(1.5, 0, 0));
}

TEST(Animation, TransformsThatLeaveTheRangeOfFloatsAreRefused) {
  GltfBuilder b = animated("scale", {0, 1}, "LINEAR", [](GltfBuilder& g) {
    return g.positions({{1, 1, 1}, {1e30f, 1e30f, 1e30f}});
  });
  const int child = b.add("nodes", {{"scale", {1e20, 1, 1}}});
  b.root["nodes"][0]["children"] = {child};
  const Scene scene = b.load();
  EXPECT_NO_THROW(nodeAt(scene, 0));
  EXPECT_THROW(nodeAt(scene, 1), Error);
}

// A cubic through its own keys with its own tangents is reproduced: x = t^3 - t over [0, 2].
TEST(Animation, CubicSplinesAreHermites) {
  const Scene scene = animated("translation", {0, 2}, "CUBICSPLINE", [](GltfBuilder& b) {
                        return b.positions({{9, 9, 9}, {0, 0, 0}, {-1, 0, 0}, {11, 0, 0}, {6, 0, 0}, {9, 9, 9}});
                      }).load();
  for (double t : {0.0, 0.3, 1.0, 1.7, 2.0}) EXPECT_NEAR(placeAt(scene, t).x, t * t * t - t, 1e-12);
}

// Quarter turns as normalized shorts, with the shorter path where the quaternion changes its sign.
TEST(Animation, RotationsGoRoundEvenly) {
  const float h = std::sqrt(0.5f);
  for (const vec4& to : {vec4(0, h, 0, h), vec4(0, -h, 0, -h)}) {
    const Scene scene = animated("rotation", {0, 1}, "LINEAR", [&](GltfBuilder& b) {
                          std::vector<int16_t> codes = {0, 0, 0, 32767};
                          for (int c = 0; c < 4; ++c) codes.push_back(int16_t(std::lround(to[c] * 32767)));
                          const int index = b.accessor(b.view(codes), kShort, "VEC4", 2);
                          b.root["accessors"][size_t(index)]["normalized"] = true;
                          return index;
                        }).load();
    for (double t : {0.0, 0.2, 0.5, 1.0}) {
      const dvec3 x(nodeAt(scene, t)[0]);
      EXPECT_NEAR(x.x, std::cos(t * M_PI / 2), 1e-4);
      EXPECT_NEAR(x.z, -std::sin(t * M_PI / 2), 1e-4);
    }
  }
}

TEST(Animation, SparseValuesCount) {
  GltfBuilder b = animated("scale", {0, 1}, "LINEAR", [](GltfBuilder& g) {
    return g.positions({{1, 1, 1}, {1, 1, 1}});
  });
  const int indices = b.view(std::vector<uint8_t>{1}), values = b.view(std::vector<vec3>{{3, 1, 1}});
  b.root["accessors"].back()["sparse"] = {{"count", 1},
                                          {"indices", {{"bufferView", indices}, {"componentType", 5121}}},
                                          {"values", {{"bufferView", values}}}};
  EXPECT_DOUBLE_EQ(nodeAt(b.load(), 0.5)[0][0], 2);
}

// The animation's first pose equals the file's, bit for bit, if they agree.
TEST(Animation, AtRestEverythingIsWhereTheFileHasIt) {
  GltfBuilder b = animated("translation", {0, 1}, "LINEAR", [](GltfBuilder& g) {
    return g.positions({{1, 2, 3}, {4, 5, 6}});
  });
  b.root["nodes"][0]["translation"] = {1, 2, 3};
  b.root["nodes"][0]["rotation"] = {.1, .2, .3, .9};
  b.root["nodes"][0]["children"] = {1};
  b.add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", .7}, {"znear", .1}}}});
  b.root["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "spot"}, {"spot", json::object()}}};
  b.use("KHR_lights_punctual");
  b.add("nodes", {{"camera", 0}, {"scale", {2, 2, 2}}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  const Scene scene = b.load();
  const Playback playback = choosePlayback(scene, "", false);
  const Pose first = poseAt(scene, playback, 0), later = poseAt(scene, playback, 1);
  EXPECT_EQ(instanceTransforms(scene, first)[0], scene.instances[0].toWorld);
  EXPECT_EQ(posedCameras(scene, first)[0].toWorld, scene.cameras[0].toWorld);
  EXPECT_EQ(posedLights(scene, first)[0].position, scene.lights[0].position);
  EXPECT_EQ(posedLights(scene, first)[0].direction, scene.lights[0].direction);
  const vec3 moved = toWorldFromGltf() * vec4(3, 3, 3, 0);
  expectNear(vec3(instanceTransforms(scene, later)[0][3] - scene.instances[0].toWorld[3]), moved);
  expectNear(vec3(posedCameras(scene, later)[0].toWorld[3] - scene.cameras[0].toWorld[3]), moved, 1e-5f);
  expectNear(posedLights(scene, later)[0].position - scene.lights[0].position, moved, 1e-5f);
}

TEST(Animation, ChosenByNameNumberOrAll) {
  GltfBuilder b = animated("translation", {0}, "STEP", [](GltfBuilder& g) { return g.positions({{1, 0, 0}}); });
  json second = b.root["animations"][0];
  second["name"] = "grow";
  second["channels"][0]["target"]["path"] = "scale";
  b.add("animations", second);
  const Scene scene = b.load();
  EXPECT_EQ(choosePlayback(scene, "", false).animations, std::vector<uint32_t>{0});
  EXPECT_EQ(choosePlayback(scene, "grow", false).animations, std::vector<uint32_t>{1});
  EXPECT_EQ(choosePlayback(scene, "1", false).animations, std::vector<uint32_t>{1});
  EXPECT_EQ(choosePlayback(scene, "all", false).animations.size(), 2u);
  try {
    choosePlayback(scene, "walk", false);
    ADD_FAILURE() << "there is none of that name";
  } catch (const Error& error) {
    EXPECT_EQ(int(error.code()), int(ExitCode::Usage));
    EXPECT_THAT(error.what(), HasSubstr("has no animation \"walk\"; it has: 0 \"move\", 1 \"grow\""));
  }
}

// --- vertices ------------------------------------------------------------------------------------------------------

// Two joints, the second of which rotates about Z; both sets of influences, with two component types and weights that
// do not sum to 1.
GltfBuilder skinned() {
  GltfBuilder b = animated("rotation", {0, 1}, "LINEAR", [](GltfBuilder& g) {
    return g.vectors(std::vector<vec4>{{0, 0, 0, 1}, {0, 0, 1, 0}});
  });
  json& attributes = b.primitive()["attributes"];
  attributes["NORMAL"] = b.vectors(std::vector<vec3>(3, vec3(0, 0, 1)));
  attributes["JOINTS_0"] = b.accessor(b.view(std::vector<uint8_t>(12, 0)), kUnsignedByte, "VEC4", 3);
  attributes["JOINTS_1"] =
      b.accessor(b.view(std::vector<uint16_t>{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}), kUnsignedShort, "VEC4", 3);
  attributes["WEIGHTS_0"] =
      b.accessor(b.view(std::vector<uint8_t>{255, 0, 0, 0, 51, 0, 0, 0, 0, 0, 0, 0}), kUnsignedByte, "VEC4", 3);
  attributes["WEIGHTS_1"] = b.vectors(std::vector<vec4>{{0, 0, 0, 0}, {.2f, 0, 0, 0}, {7, 0, 0, 0}});
  b.node({{"name", "root"}, {"children", {2}}});
  b.add("nodes", {{"name", "turning"}});
  b.add("skins", {{"joints", {1, 2}}});
  b.root["nodes"][0]["skin"] = 0;
  b.root["animations"][0]["channels"][0]["target"]["node"] = 2;
  return b;
}

TEST(Skins, BothSetsOfInfluencesMoveVertices) {
  const Scene scene = skinned().load();
  ASSERT_TRUE(scene.meshes[0].deformation);
  const Deformation& d = *scene.meshes[0].deformation;
  ASSERT_EQ(d.influences, 8u);
  const Pose pose = poseAt(scene, choosePlayback(scene, "", false), 0.5);  // a quarter turn
  const DeformedVertices v = deform(d, jointMatrices(scene.rig.skins[0], pose), {});
  expectNear(v.positions[0], vec3(0, 0, 0));
  expectNear(v.positions[1], vec3(.5f, .5f, 0));  // halfway between (1,0,0) and (0,1,0)
  expectNear(v.positions[2], vec3(-1, 0, 0));     // fully rotated (0,1,0)
  EXPECT_EQ(instanceTransforms(scene, pose)[0], toWorldFromGltf());
}

// Worlds pose skins that the file does not animate. No time has a pose.
TEST(Skins, WithoutAnAnimationTheyAreKept) {
  GltfBuilder b = skinned();
  const Scene animated = b.load();
  b.root.erase("animations");
  const Scene scene = b.load();
  ASSERT_TRUE(scene.meshes[0].deformation);
  EXPECT_EQ(scene.meshes[0].deformation->joints, animated.meshes[0].deformation->joints);
  EXPECT_EQ(scene.meshes[0].positions, animated.meshes[0].positions);
  EXPECT_EQ(scene.rig.skins.at(0).joints, animated.rig.skins.at(0).joints);
  EXPECT_TRUE(poseAt(scene, choosePlayback(scene, "", false), 0.5).empty());
  EXPECT_EQ(jointMatrices(scene.rig.skins[0], restPose(scene)),
            jointMatrices(animated.rig.skins[0], restPose(animated)));
}

// Joints as EXT_meshopt_compression stores them, with four bytes per vertex.
TEST(Skins, CompressedJointsAreTheSame) {
  GltfBuilder b = skinned();
  const json plain = b.root;
  const Scene expected = b.load();
  const int accessor = b.primitive()["attributes"]["JOINTS_0"].get<int>();
  std::vector<uint8_t> joints = {0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0};
  std::vector<unsigned char> encoded(meshopt_encodeVertexBufferBound(3, 4));
  encoded.resize(meshopt_encodeVertexBuffer(encoded.data(), encoded.size(), joints.data(), 3, 4));
  const int view = b.view(std::as_bytes(std::span(encoded)));
  json& item = b.root["bufferViews"][size_t(view)];
  item["extensions"]["EXT_meshopt_compression"] = {{"buffer", 0},
                                                   {"byteOffset", item["byteOffset"]},
                                                   {"byteLength", encoded.size()},
                                                   {"byteStride", 4},
                                                   {"count", 3},
                                                   {"mode", "ATTRIBUTES"}};
  item["byteLength"] = 12;
  b.root["accessors"][size_t(accessor)]["bufferView"] = view;
  const Scene scene = b.load();
  ASSERT_TRUE(scene.meshes[0].deformation);
  EXPECT_EQ(scene.meshes[0].deformation->joints[16], 1u);
  EXPECT_EQ(scene.meshes[0].deformation->jointWeights, expected.meshes[0].deformation->jointWeights);
}

TEST(MorphTargets, WeightsMoveVerticesAndNormals) {
  GltfBuilder b = animated("weights", {0, 1}, "LINEAR", [](GltfBuilder& g) {
    return g.accessor(g.view(std::vector<uint8_t>{0, 0, 255, 51}), kUnsignedByte, "SCALAR", 4);
  });
  b.primitive()["attributes"]["NORMAL"] = b.vectors(std::vector<vec3>(3, vec3(0, 0, 1)));
  const int up = b.positions(std::vector<vec3>(3, vec3(0, 0, 4))),
            side = b.positions(std::vector<vec3>(3, vec3(5, 0, 0)));
  const int tilt = b.vectors(std::vector<vec3>(3, vec3(0, 2, 0)));
  b.primitive()["targets"] = {{{"POSITION", up}, {"NORMAL", tilt}}, {{"POSITION", side}}};
  b.root["meshes"][0]["weights"] = {0.5, 0};
  const Scene scene = b.load();
  EXPECT_EQ(scene.meshes[0].positions[0], vec3(0, 0, 2));  // at rest
  const Pose pose = poseAt(scene, choosePlayback(scene, "", false), 1);
  const Deformation& d = *scene.meshes[0].deformation;
  const DeformedVertices v = deform(d, {}, pose.weights[0]);
  expectNear(v.positions[1], vec3(2, 0, 4));
  expectNear(v.attributes[1].normal, glm::normalize(vec3(0, 2, 1)));
}

// Two nodes share a mesh, and an animation changes the weights of one.
TEST(MorphTargets, EachNodeHasItsOwnWeights) {
  GltfBuilder b = animated("weights", {0}, "STEP", [](GltfBuilder& g) {
    return g.accessor(g.view(std::vector<float>{1}), kFloat, "SCALAR", 1);
  });
  b.primitive()["targets"] = {{{"POSITION", b.positions(std::vector<vec3>(3, vec3(0, 0, 4)))}}};
  b.node({{"mesh", 0}});
  const Scene scene = b.load();
  ASSERT_EQ(scene.meshes.size(), 2u);
  EXPECT_TRUE(scene.meshes[scene.instances[0].mesh].deformation);
  EXPECT_FALSE(scene.meshes[scene.instances[1].mesh].deformation);
}

// For all random joints and weights, the box contains the mesh.
TEST(Reach, HoldsWhatItDeforms) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit(-1, 1);
  const auto vector = [&] { return vec3(unit(random), unit(random), unit(random)); };
  for (int round = 0; round < 200; ++round) {
    Deformation d;
    d.influences = 4;
    d.targets.resize(2);
    for (int i = 0; i < 30; ++i) {
      d.positions.push_back(vector());
      d.attributes.push_back({vec3(0, 0, 1), vec4(0), vec2(0)});
      float sum = 0, weights[4];
      for (float& w : weights) sum += w = std::abs(unit(random));
      for (float w : weights) d.joints.push_back(uint32_t(random() % 5)), d.jointWeights.push_back(w / sum);
      for (MorphTarget& target : d.targets) target.positions.push_back(vector());
    }
    std::vector<mat4> joints(5, mat4(1));
    for (mat4& joint : joints)
      for (int c = 0; c < 4; ++c) joint[c] = vec4(vector(), c == 3);
    const std::vector<float> weights = {unit(random) * 2, unit(random)};
    const ReachBox box = deformedBox(reachOf(d), joints, weights);
    for (const vec3& p : deform(d, joints, weights).positions)
      for (int axis = 0; axis < 3; ++axis) {
        ASSERT_GE(p[axis], box.low[axis]);
        ASSERT_LE(p[axis], box.high[axis]);
      }
  }
}

// --- invalid files --------------------------------------------------------------------------------------------------

TEST(Animation, BrokenFilesAreRefusedBySentence) {
  const auto broken = [](const std::function<void(GltfBuilder&, json&)>& breakIt) {
    GltfBuilder b = animated("translation", {0, 1}, "LINEAR", [](GltfBuilder& g) {
      return g.positions({{0, 0, 0}, {1, 0, 0}});
    });
    breakIt(b, b.root["animations"][0]);
    return errorOf(b);
  };
  EXPECT_THAT(broken([](GltfBuilder&, json& a) { a["channels"][0]["sampler"] = 3; }),
              HasSubstr("sampler is 3, but there are 1 samplers"));
  EXPECT_THAT(broken([](GltfBuilder&, json& a) { a["channels"][0]["target"]["node"] = 7; }),
              HasSubstr("animations[0].channels[0].target.node is 7, but there are 1 nodes"));
  EXPECT_THAT(broken([](GltfBuilder&, json& a) { a["channels"][0]["target"]["path"] = "rotation"; }),
              HasSubstr("the wrong number of values or components"));
  EXPECT_THAT(broken([](GltfBuilder&, json& a) { a["samplers"][0]["interpolation"] = "CUBICSPLINE"; }),
              HasSubstr("the wrong number of values"));
}

// glTF 2.0, 3.11: rotations and weights may be integers; matrices and other integers have no values.
TEST(Animation, OutputsOfOtherTypesAreRefused) {
  const auto fileOf = [](const char* path, Component component, const char* type, size_t bytes) {
    return animated(path, {0, 1}, "LINEAR", [&](GltfBuilder& b) {
      return b.accessor(b.view(std::vector<uint8_t>(2 * bytes, 1)), component, type, 2);
    });
  };
  EXPECT_THAT(errorOf(fileOf("translation", kShort, "VEC3", 6)),
              HasSubstr("animations[0].channels[0]'s translation is VEC3 of SHORT, in accessors["));
  EXPECT_THAT(errorOf(fileOf("scale", kUnsignedInt, "VEC3", 12)), HasSubstr("it must be VEC3 of FLOAT"));
  EXPECT_THAT(errorOf(fileOf("rotation", kUnsignedInt, "VEC4", 16)), HasSubstr("is VEC4 of UNSIGNED_INT"));
  EXPECT_THAT(errorOf(fileOf("rotation", kFloat, "MAT2", 16)), HasSubstr("is MAT2 of FLOAT"));
  for (const Component component : {kByte, kUnsignedByte, kShort, kUnsignedShort})
    EXPECT_TRUE(fileOf("rotation", component, "VEC4", 8).load().rig.isAnimated());
}

// Only an invalid channel is skipped: the file is read, and the channel next to it moves the node.
TEST(Animation, ChannelsThatCanNotApplyAreLeftOut) {
  const auto leftOut = [](const std::function<void(GltfBuilder&, json&)>& breakIt) {
    GltfBuilder b = animated("translation", {0, 1}, "LINEAR", [](GltfBuilder& g) {
      return g.positions({{0, 0, 0}, {1, 0, 0}});
    });
    json& animation = b.root["animations"][0];
    animation["samplers"].push_back(animation["samplers"][0]);
    animation["channels"].push_back(animation["channels"][0]);
    animation["channels"][0]["sampler"] = 1;
    breakIt(b, animation);
    testing::internal::CaptureStderr();
    const Scene scene = b.load();
    EXPECT_EQ(scene.rig.animations.at(0).tracks.size(), 1u);
    EXPECT_EQ(placeAt(scene, 0.5), dvec3(0.5, 0, 0));
    return testing::internal::GetCapturedStderr();
  };
  const auto withTimes = [&](std::vector<float> times) {
    return leftOut([&](GltfBuilder& b, json& a) {
      a["samplers"][1]["input"] = b.accessor(b.view(times), kFloat, "SCALAR", times.size());
    });
  };
  EXPECT_THAT(leftOut([](GltfBuilder&, json& a) { a["samplers"][1]["interpolation"] = "BEZIER"; }),
              HasSubstr("animations[0].channels[0] has the unknown interpolation \"BEZIER\", and is left out"));
  EXPECT_THAT(leftOut([](GltfBuilder&, json& a) { a["channels"][0]["target"]["path"] = "colour"; }),
              HasSubstr("moves \"colour\", which no node has"));
  EXPECT_THAT(leftOut([](GltfBuilder&, json& a) { a["channels"][0]["target"]["path"] = "weights"; }),
              HasSubstr("moves weights of nodes[0], whose mesh has no morph targets"));
  EXPECT_THAT(withTimes({1, 0}), HasSubstr("has times that fall"));
  EXPECT_THAT(withTimes({-1, 0}), HasSubstr("has a time before 0"));
  EXPECT_THAT(withTimes({0, NAN}), HasSubstr("not finite numbers"));
  EXPECT_THAT(
      leftOut([](GltfBuilder& b, json& a) {
        b.positions({{0, 0, 0}});  // a different accessor than in the case before, because warnings are not repeated
        a["samplers"][1]["output"] = b.positions({{0, 0, 0}, {NAN, 0, 0}});
      }),
      HasSubstr("not finite numbers"));
}

TEST(Animation, MayHaveNoChannels) {
  GltfBuilder b = triangleFile();
  b.add("animations", {{"channels", json::array()}, {"samplers", json::array()}});
  const Scene scene = b.load();
  EXPECT_EQ(duration(scene, choosePlayback(scene, "", false)), 0);
  EXPECT_EQ(scene.instances.size(), 1u);
}

// glTF 2.0, 3.7.2.2: the number of weights equals the number of targets, whichever primitive has them.
TEST(Animation, MorphTargetsMayBeOnAnyPrimitive) {
  for (const size_t with : {0u, 1u}) {
    GltfBuilder b = triangleFile();
    json plain = b.primitive(), morphed = plain;
    morphed["targets"] = {{{"POSITION", b.vectors(std::vector<vec3>{{0, 0, 0}, {0, 0, 2}, {0, 0, 0}})}}};
    b.root["meshes"][0]["primitives"] = with == 0 ? json{morphed, plain} : json{plain, morphed};
    const int times = b.accessor(b.view(std::vector<float>{0, 1}), kFloat, "SCALAR", 2);
    const int weights = b.accessor(b.view(std::vector<float>{0, 1}), kFloat, "SCALAR", 2);
    b.add("animations", {{"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}},
                         {"samplers", {{{"input", times}, {"output", weights}}}}});
    const Scene scene = b.load();
    ASSERT_EQ(scene.instances.size(), 2u);
    EXPECT_EQ(scene.meshes[scene.instances[1 - with].mesh].deformation, nullptr);
    const Deformation* deformation = scene.meshes[scene.instances[with].mesh].deformation.get();
    ASSERT_NE(deformation, nullptr) << with;
    const Pose pose = poseAt(scene, choosePlayback(scene, "", false), 0.75);
    EXPECT_EQ(deform(*deformation, {}, pose.weights[0]).positions[1], vec3(1, 0, 1.5f));
  }
}

// --- mirroring skins ------------------------------------------------------------------------------------------------

// The triangle, with tangents for a normal map, moved by one joint below a node with this scale. Its normal is +Z.
GltfBuilder skinnedTriangle(const std::vector<double>& scale) {
  GltfBuilder b = triangleFile();
  b.primitive()["attributes"]["NORMAL"] = b.vectors(std::vector<vec3>(3, {0, 0, 1}));
  b.primitive()["attributes"]["TANGENT"] = b.vectors(std::vector<vec4>(3, {1, 0, 0, 1}));
  b.primitive()["attributes"]["JOINTS_0"] = b.accessor(b.view(std::vector<uint8_t>(12, 0)), kUnsignedByte, "VEC4", 3);
  b.primitive()["attributes"]["WEIGHTS_0"] = b.vectors(std::vector<vec4>(3, {1, 0, 0, 0}));
  const int joint = b.add("nodes", json::object());
  b.node({{"scale", scale}, {"children", {joint}}});
  b.add("skins", {{"joints", {joint}}});
  b.root["nodes"][0]["skin"] = 0;
  return b;
}

// Front faces are counter-clockwise in the rest pose, whatever the joints do, and the tangent frame is mirrored:
// cross(normal, tangent) w follows v, which the joints transform like positions.
TEST(Skin, MirroredTrianglesKeepTheirFronts) {
  const double turns[][3] = {{1, 1, 1}, {-1, 1, 1}, {1, -1, 1}, {1, 1, -1}, {-1, -1, 1}, {-2, -3, -1}};
  for (const auto& s : turns) {
    const Scene scene = skinnedTriangle({s[0], s[1], s[2]}).load();
    const Mesh& mesh = scene.meshes.at(0);
    const vec3 scale(s[0], s[1], s[2]);
    const auto corner = [&](size_t i) { return mesh.positions[mesh.indices[i]]; };
    const shared::VertexAttributes& a = mesh.attributes[0];
    expectNear(mesh.positions[1], vec3(scale.x, 0, 0));
    expectNear(a.normal, vec3(0, 0, scale.z < 0 ? -1 : 1));
    EXPECT_GT(glm::dot(glm::cross(corner(1) - corner(0), corner(2) - corner(0)), a.normal), 0) << s[0] << s[1] << s[2];
    expectNear(glm::cross(a.normal, vec3(a.tangent)) * a.tangent.w, vec3(0, scale.y < 0 ? -1 : 1, 0));
  }
}

// Joints at UTM coordinates, where neighboring floats are 6 cm apart.
TEST(Skin, FarJointsKeepTheirPrecision) {
  const glm::dvec3 far(1000000.1, -750000.3, 125000.7), step(0.01, 0.02, -0.03);
  for (const bool animated : {false, true}) {
    GltfBuilder b = skinnedTriangle({2, 1, 1});
    b.root["nodes"][2]["translation"] = {far.x, far.y, far.z};
    if (animated) {
      const int times = b.accessor(b.view(std::vector<float>{0, 1}), kFloat, "SCALAR", 2);
      b.add("animations",
            {{"channels", {{{"sampler", 0}, {"target", {{"node", 1}, {"path", "translation"}}}}}},
             {"samplers", {{{"input", times}, {"output", b.vectors(std::vector{vec3(0), vec3(step)})}}}}});
    }
    const Scene scene = b.load();
    const Mesh& mesh = scene.meshes.at(0);
    const auto at = [](const glm::dmat4& place, vec3 p) { return glm::dvec3(place * glm::dvec4(p, 1)); };
    const auto world = [](glm::dvec3 p) { return glm::dvec3(toWorldFromGltf() * glm::dvec4(p, 1)); };
    const glm::dvec3 rest = world(far + glm::dvec3(2, 0, 0));
    EXPECT_LT(glm::length(at(scene.instances.at(0).toWorld, mesh.positions[1]) - rest), 1e-5);
    if (!animated) continue;
    const Pose pose = poseAt(scene, choosePlayback(scene, "", false), 0.5);
    const DeformedVertices posed = deform(*mesh.deformation, jointMatrices(scene.rig.skins.at(0), pose), {});
    const glm::dvec3 moved = rest + world(glm::dvec3(2, 1, 1) * step * 0.5);
    EXPECT_LT(glm::length(at(instanceTransforms(scene, pose).at(0), posed.positions[1]) - moved), 1e-5);
  }
}

TEST(Skin, MirrorsAsMostOfItsWeightDoes) {
  Deformation d;
  d.influences = 4;
  for (int vertex = 0; vertex < 3; ++vertex) {
    d.positions.emplace_back(0);
    d.attributes.push_back({vec3(0, 0, 1), vec4(0), vec2(0)});
    for (const auto& [joint, weight] : {std::pair(0u, 0.75f), {1u, 0.25f}, {0u, 0.0f}, {0u, 0.0f}})
      d.joints.push_back(joint), d.jointWeights.push_back(weight);
  }
  const mat4 mirror = glm::scale(mat4(1), vec3(-1, 1, 1)), flat = glm::scale(mat4(1), vec3(0, 1, 1));
  const Reach reach = reachOf(d);
  EXPECT_FALSE(isMirrored(reach, std::vector{mat4(1), mat4(1)}));
  EXPECT_TRUE(isMirrored(reach, std::vector{mirror, mat4(1)}));
  EXPECT_FALSE(isMirrored(reach, std::vector{mat4(1), mirror}));
  EXPECT_TRUE(isMirrored(reach, std::vector{flat, mirror}));
  EXPECT_FALSE(isMirrored(reach, std::vector{flat, flat}));
}

}  // namespace
}  // namespace latelight::scene::test
