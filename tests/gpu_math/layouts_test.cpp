// The structs of shared/types.h lie in device memory as they do in the host's.
#include <gtest/gtest.h>

#include <cstddef>

#include "gpu_math/spirv.h"
#include "shared/types.h"

namespace latelight::shared {
namespace {

struct HostMember {
  std::string name;
  size_t offset;
};
struct HostStruct {
  std::string name;
  size_t size;
  bool inArrays;  // read as an element of an array: its size matters too
  std::vector<HostMember> members;
};

#define MEMBER(type, member)        \
  HostMember {                      \
#member, offsetof(type, member) \
  }

std::vector<HostStruct> hostStructs() {
  return {
      {"Projection",
       sizeof(Projection),
       false,
       {MEMBER(Projection, H), MEMBER(Projection, V), MEMBER(Projection, A), MEMBER(Projection, B),
        MEMBER(Projection, X), MEMBER(Projection, Z), MEMBER(Projection, kind)}},
      {"VertexAttributes",
       sizeof(VertexAttributes),
       true,
       {MEMBER(VertexAttributes, normal), MEMBER(VertexAttributes, tangent), MEMBER(VertexAttributes, uv0)}},
      {"VertexExtra", sizeof(VertexExtra), true, {MEMBER(VertexExtra, uv1), MEMBER(VertexExtra, color)}},
      {"Mesh",
       sizeof(Mesh),
       true,
       {MEMBER(Mesh, positions), MEMBER(Mesh, attributes), MEMBER(Mesh, extras), MEMBER(Mesh, indices),
        MEMBER(Mesh, previousPositions), MEMBER(Mesh, nextPositions), MEMBER(Mesh, vertexCount),
        MEMBER(Mesh, triangleCount)}},
      {"Instance",
       sizeof(Instance),
       true,
       {MEMBER(Instance, objectToWorld), MEMBER(Instance, mesh), MEMBER(Instance, material), MEMBER(Instance, id),
        MEMBER(Instance, part), MEMBER(Instance, flags)}},
      {"TextureTransform",
       sizeof(TextureTransform),
       true,
       {MEMBER(TextureTransform, row0), MEMBER(TextureTransform, row1), MEMBER(TextureTransform, uvSet)}},
      {"Material",
       sizeof(Material),
       true,
       {MEMBER(Material, baseColor), MEMBER(Material, emissive), MEMBER(Material, metallic),
        MEMBER(Material, roughness), MEMBER(Material, normalScale), MEMBER(Material, occlusionStrength),
        MEMBER(Material, alphaCutoff), MEMBER(Material, specularColor), MEMBER(Material, specular),
        MEMBER(Material, f0), MEMBER(Material, flags), MEMBER(Material, textures), MEMBER(Material, id),
        MEMBER(Material, transforms)}},
      {"Light",
       sizeof(Light),
       true,
       {MEMBER(Light, position), MEMBER(Light, reach), MEMBER(Light, direction), MEMBER(Light, type),
        MEMBER(Light, intensity), MEMBER(Light, spotScale), MEMBER(Light, spotOffset), MEMBER(Light, shadow)}},
      {"Fog", sizeof(Fog), false, {MEMBER(Fog, color), MEMBER(Fog, density), MEMBER(Fog, falloff), MEMBER(Fog, base)}},
      {"LightBox", sizeof(LightBox), true, {MEMBER(LightBox, low), MEMBER(LightBox, high)}},
      {"View",
       sizeof(View),
       true,
       {MEMBER(View, worldToView), MEMBER(View, viewToWorld), MEMBER(View, projection), MEMBER(View, eye),
        MEMBER(View, size), MEMBER(View, jitter)}},
      {"FrameConstants",
       sizeof(FrameConstants),
       false,
       {MEMBER(FrameConstants, views),
        MEMBER(FrameConstants, instances),
        MEMBER(FrameConstants, meshes),
        MEMBER(FrameConstants, materials),
        MEMBER(FrameConstants, lights),
        MEMBER(FrameConstants, lightTree),
        MEMBER(FrameConstants, previousInstances),
        MEMBER(FrameConstants, nextInstances),
        MEMBER(FrameConstants, previousViews),
        MEMBER(FrameConstants, nextViews),
        MEMBER(FrameConstants, viewCount),
        MEMBER(FrameConstants, lightCount),
        MEMBER(FrameConstants, directionalLights),
        MEMBER(FrameConstants, lightTreeLeaves),
        MEMBER(FrameConstants, exposure),
        MEMBER(FrameConstants, environmentIntensity),
        MEMBER(FrameConstants, environmentCos),
        MEMBER(FrameConstants, environmentSin),
        MEMBER(FrameConstants, environmentLevels),
        MEMBER(FrameConstants, fog)}},
  };
}

// Blocks (FrameRef, Push...) are the shader's own; every other struct in a buffer must be one of the host's.
bool isBlock(const std::string& name) {
  return name == "Push" || (name.size() > 3 && name.ends_with("Ref"));
}

TEST(Layouts, EveryMemberLiesWhereTheHostHasIt) {
  const auto device = test::structLayouts(test::readSpirv("gpu_math_layouts"));
  for (const HostStruct& host : hostStructs()) {
    ASSERT_TRUE(device.count(host.name)) << host.name << " is not in the shader";
    const test::StructLayout& layout = device.at(host.name);
    ASSERT_EQ(layout.members.size(), host.members.size()) << host.name;
    for (size_t i = 0; i < host.members.size(); ++i) {
      EXPECT_EQ(layout.members[i], host.members[i].name) << host.name;
      EXPECT_EQ(layout.offsets[i], host.members[i].offset) << host.name << "::" << host.members[i].name;
    }
    if (host.inArrays) {
      EXPECT_EQ(layout.stride, host.size) << host.name;
    }
    for (const auto& [member, stride] : layout.matrices) EXPECT_EQ(stride, sizeof(vec3)) << host.name;
  }
}

TEST(Layouts, EveryStructOfTheDeviceIsChecked) {
  std::vector<std::string> checked;
  for (const HostStruct& host : hostStructs()) checked.push_back(host.name);
  for (const auto& [name, layout] : test::structLayouts(test::readSpirv("gpu_math_layouts"))) {
    if (!isBlock(name)) {
      EXPECT_NE(std::find(checked.begin(), checked.end(), name), checked.end()) << name;
    }
  }
}

}  // namespace
}  // namespace latelight::shared
