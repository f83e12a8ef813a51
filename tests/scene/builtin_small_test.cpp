// builtin:boxes, builtin:spheres, the grammar of the names and the values that scene.cpp computes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "base/error.h"
#include "base/hash.h"
#include "builtin_checks.h"
#include "scene/builtin/builtin.h"
#include "scene/exact_math.h"
#include "scene/load/load.h"
#include "shared/light.h"
#include "shared/projection.h"

namespace latelight::scene {
namespace {

std::string usageError(const std::string& source) {
  try {
    load(source);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::Usage) << source;
    return error.what();
  }
  ADD_FAILURE() << source << " was accepted";
  return {};
}

TEST(BuiltinNames, WrongOnesListWhatThereIs) {
  EXPECT_THAT(usageError("builtin:castle"), testing::AllOf(testing::HasSubstr("castle"), testing::HasSubstr("hall"),
                                                           testing::HasSubstr("spheres"), testing::HasSubstr("boxes")));
  EXPECT_THAT(usageError("builtin:"), testing::HasSubstr("builtin:hall"));
  EXPECT_THAT(usageError("builtin:hall,windows=3"), testing::HasSubstr("triangles (50k to 50M)"));
  EXPECT_THAT(usageError("builtin:hall,lights"), testing::HasSubstr("key=value"));
  EXPECT_THAT(usageError("builtin:hall,"), testing::HasSubstr("key=value"));
  EXPECT_THAT(usageError("builtin:boxes,size=3"), testing::HasSubstr("none"));
  for (const char* value : {"lights=0", "lights=2M", "lights=-1", "lights=1.5", "lights=", "lights=x", "lights=1e3",
                            "triangles=49999", "triangles=51M", "triangles=1.23456789M",
                            "triangles=99999999999999999999", "triangles=.5M", "triangles=1.M", "triangles=300K"})
    EXPECT_THAT(usageError(std::string("builtin:hall,") + value), testing::HasSubstr(value));
}

// --- builtin:triangles ----------------------------------------------------------------------------------------------

TEST(BuiltinTriangles, AreAsManyAndAsLargeAsAsked) {
  const Scene scene = load("builtin:triangles,count=1000200,size=35");
  EXPECT_EQ(scene.triangleCount(), 1'000'200u);
  ASSERT_EQ(scene.meshes.size(), 2u);
  const Mesh& mesh = scene.meshes[1];
  ASSERT_EQ(mesh.indices.size(), 600u);
  const double leg = 3.5 * 2 / kTrianglesPicture;  // in the center, where the picture is 2 meters high
  for (size_t i = 0; i < mesh.positions.size(); i += 3) {
    const glm::dvec3 a(mesh.positions[i]), b(mesh.positions[i + 1]), c(mesh.positions[i + 2]);
    EXPECT_NEAR(glm::length(b - a), leg, leg * 1e-3);
    EXPECT_NEAR(glm::length(c - a), leg, leg * 1e-3);
    EXPECT_NEAR(glm::dot(b - a, c - a), 0, leg * leg * 1e-3);
    EXPECT_GT(glm::cross(b - a, c - a).z, 0);  // towards the camera
    EXPECT_LE(std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)}), 1.01);
  }
  EXPECT_THAT(usageError("builtin:triangles,size=1.5"), testing::HasSubstr("size to a whole number from 1 to 20480"));
}

// --- names ----------------------------------------------------------------------------------------------------------

TEST(BuiltinNames, AVariantIsRefused) {
  LoadOptions options;
  options.variant = "red";
  EXPECT_THROW(load("builtin:boxes", options), Error);
}

TEST(Load, SaysWhatIsNotASceneFile) {
  for (const char* path : {"no such file.glb", ".", "hall"}) {
    try {
      load(path);
      ADD_FAILURE() << path << " was accepted";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::BadInput);
      EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr(path), testing::HasSubstr("builtin:hall")));
    }
  }
}

TEST(Axes, ConvertBothWaysExactly) {
  EXPECT_EQ(toWorldFromGltf() * toGltfFromWorld(), dmat4(1));
  EXPECT_EQ(toWorldFromGltf() * glm::dvec4(1, 2, 3, 1), glm::dvec4(1, -3, 2, 1));
}

TEST(ExactMath, AgreesWithLibm) {
  for (int i = -2000; i <= 2000; ++i) {
    const double x = i * 0.0137;
    EXPECT_NEAR(exact::sine(x), std::sin(x), 1e-13);
    EXPECT_NEAR(exact::cosine(x), std::cos(x), 1e-13);
    EXPECT_NEAR(exact::exponential(x) / std::exp(x), 1, 1e-12);
    if (i > 0) {
      EXPECT_NEAR(exact::logarithm2(x), std::log2(x), 1e-13);
      EXPECT_NEAR(exact::power(x, 1.7) / std::pow(x, 1.7), 1, 1e-12);
    }
    const double turns = exact::turnsOf(std::sin(x), std::cos(x));
    EXPECT_NEAR(std::remainder(turns - x / exact::kTau, 1.0), 0, 1e-12);
  }
  for (int q = -8; q <= 8; ++q) EXPECT_EQ(std::abs(exact::sinQuarters(q)), q % 2 ? 1.0 : 0.0);
}

TEST(Boxes, AreWhereTheirConstantsSay) {
  const Scene scene = load("builtin:boxes");
  EXPECT_EQ(scene.name, "boxes");
  EXPECT_EQ(scene.source, "builtin:boxes");
  ASSERT_EQ(scene.instances.size(), boxesBoxes().size());
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const BoxesBox& box = boxesBoxes()[i];
    const Instance& instance = scene.instances[i];
    EXPECT_EQ(instance.id, hash32("/boxes/" + std::string(box.name)));
    EXPECT_EQ(scene.nodes[instance.node].path, "/boxes/" + std::string(box.name));
    EXPECT_EQ(glm::determinant(glm::mat3(instance.toWorld)) < 0, box.mirrored);
    Bounds bounds;
    for (const vec3& p : scene.meshes[instance.mesh].positions) {
      const dvec3 gltf = toGltfFromWorld() * instance.toWorld * glm::dvec4(p, 1);
      bounds.min = glm::min(bounds.min, gltf);
      bounds.max = glm::max(bounds.max, gltf);
    }
    EXPECT_EQ(vec3(bounds.min), box.min) << box.name;
    EXPECT_EQ(vec3(bounds.max), box.max) << box.name;
  }
  checkMeshes(scene);
  checkWatertight(scene.meshes[0]);
}

TEST(Boxes, AreLitAsTheHeaderWorksOut) {
  const Scene scene = load("builtin:boxes");
  ASSERT_EQ(scene.lights.size(), 1u);
  const Light& sun = scene.lights[0];
  EXPECT_EQ(sun.type, shared::kLightDirectional);
  EXPECT_NEAR(glm::length(sun.direction), 1, 1e-6f);
  const auto radiance = [&](vec3 gltfNormal) {
    const vec3 n = toWorldFromGltf() * vec4(gltfNormal, 0);
    return sun.intensity * std::max(0.0f, -glm::dot(n, sun.direction)) / shared::kPi;
  };
  EXPECT_NEAR(radiance({0, 1, 0}), 1.0, 1e-6);
  EXPECT_NEAR(radiance({0, 0, 1}), 0.5, 1e-6);
  EXPECT_NEAR(radiance({1, 0, 0}), 1.0 / 3, 1e-6);
  EXPECT_EQ(radiance({-1, 0, 0}), 0.0f);
}

TEST(Boxes, AreSeenWhereTheHeaderWorksOut) {
  const Scene scene = load("builtin:boxes");
  ASSERT_EQ(scene.cameras.size(), 1u);
  const Camera& camera = scene.cameras[0];
  EXPECT_EQ(camera.name, "main");
  EXPECT_NEAR(1.0f / std::tan(0.5f * camera.verticalFov), 2.0f, 1e-6f);
  const shared::Projection projection{1.0f, 2.0f, 0, camera.nearClip, 0, 0, shared::kPerspective};  // aspect 2
  const vec2 size(200, 100);
  for (const vec3 p : {vec3(-4, 0.25f, -0.5f), vec3(1.25f, 3.25f, -2.5f), vec3(0, 0, -5)}) {
    const vec3 view = glm::inverse(camera.toWorld) * toWorldFromGltf() * vec4(p, 1);
    EXPECT_NEAR(view.y, kBoxesEye.z - p.z, 1e-6f);
    const vec4 clip = projectToClip(projection, view);
    const vec2 pixel((clip.x / clip.w * 0.5f + 0.5f) * size.x, (0.5f - clip.y / clip.w * 0.5f) * size.y);
    EXPECT_NEAR(pixel.x, size.x / 2 + size.y * (p.x - kBoxesEye.x) / view.y, 1e-4f);
    EXPECT_NEAR(pixel.y, size.y / 2 - size.y * (p.y - kBoxesEye.y) / view.y, 1e-4f);
  }
}

TEST(Spheres, SpanMetalnessAndRoughnessOverAGrid) {
  const Scene scene = load("builtin:spheres");
  ASSERT_EQ(scene.instances.size(), size_t{kSpheresColumns} * kSpheresRows);
  EXPECT_TRUE(scene.lights.empty());
  ASSERT_EQ(scene.cameras.size(), 1u);
  std::set<uint32_t> ids;
  for (uint32_t row = 0; row < kSpheresRows; ++row) {
    for (uint32_t column = 0; column < kSpheresColumns; ++column) {
      const Instance& instance = scene.instances[row * kSpheresColumns + column];
      const shared::Material& material = scene.materials[instance.material].data;
      EXPECT_FLOAT_EQ(material.metallic, float(column) / float(kSpheresColumns - 1));
      EXPECT_FLOAT_EQ(material.roughness, float(row) / float(kSpheresRows - 1));
      EXPECT_EQ(vec3(toGltfFromWorld() * instance.toWorld[3]), spheresCenter(column, row));
      ids.insert(instance.id);
    }
  }
  EXPECT_EQ(ids.size(), scene.instances.size());
}

TEST(Spheres, AreRoundAndClosed) {
  const Scene scene = load("builtin:spheres");
  const Mesh& mesh = scene.meshes[0];
  for (size_t i = 0; i < mesh.positions.size(); ++i)
    ASSERT_LT(glm::length(mesh.positions[i] - mesh.attributes[i].normal * kSpheresRadius), 1e-6f);
  checkMeshes(scene);
  checkWatertight(mesh);
}

}  // namespace
}  // namespace latelight::scene
