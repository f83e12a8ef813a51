// Every struct that C++ and shaders share has the same memory layout on the device and the host, and shaders access no
// other structs in memory.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <map>
#include <set>

#include "gpu_math/spirv.h"
#include "struct_headers.h"
#include "vk/reflection.h"

namespace latelight::shared {
namespace {

using testing::ContainerEq;
using testing::IsEmpty;

struct HostMember {
  std::string name;
  size_t offset;
};
struct HostStruct {
  size_t size;
  std::vector<HostMember> members;
};

// By name; structs.inc lists the structs that the build found in the headers.
const std::map<std::string, HostStruct>& hostStructs() {
#define MEMBER(type, member) {#member, offsetof(type, member)},
#define STRUCT(type, members) {#type, {sizeof(type), {members}}},
  static const std::map<std::string, HostStruct> structs = {
#include "structs.inc"
  };
#undef STRUCT
#undef MEMBER
  return structs;
}

// Describes how the device's struct differs from the host's; empty if they are equal.
std::string difference(const HostStruct& host, const vk::StructLayout& device) {
  if (device.members.size() != host.members.size())
    return fmt::format("{} has {} members, {} on the host", device.name, device.members.size(), host.members.size());
  for (size_t i = 0; i < host.members.size(); ++i) {
    const vk::MemberLayout& member = device.members[i];
    if (member.name != host.members[i].name || member.offset != host.members[i].offset)
      return fmt::format("{}::{} is at {}, {} at {} on the host", device.name, member.name, member.offset,
                         host.members[i].name, host.members[i].offset);
    if (member.matrixStride != 0 && member.matrixStride != sizeof(vec3))
      return fmt::format("{}::{} has columns of {} bytes", device.name, member.name, member.matrixStride);
  }
  if (device.stride != 0 && device.stride != host.size)
    return fmt::format("{} takes {} bytes in arrays, {} on the host", device.name, device.stride, host.size);
  return "";
}

// The same for a shader's struct, by its name.
std::string difference(const vk::StructLayout& device) {
  const auto host = hostStructs().find(device.name);
  return host == hostStructs().end() ? device.name + " is in no shared header" : difference(host->second, device);
}

TEST(Layouts, EveryMemberLiesWhereTheHostHasIt) {
  std::set<std::string> host, inArrays;
  for (const auto& [name, layout] : hostStructs()) host.insert(name);
  for (const vk::StructLayout& layout : vk::reflect(test::readSpirv("gpu_math_layouts")).structs) {
    if (layout.isBlock) continue;
    EXPECT_THAT(difference(layout), IsEmpty());
    // otherwise a separate type, used as a member of another struct
    if (layout.stride != 0) inArrays.insert(layout.name);
  }
  EXPECT_THAT(inArrays, ContainerEq(host));
  for (const char* name : {"Projection", "Fog", "FrameConstants", "Fragment", "DrawPush", "LightDraw", "TemporalPush"})
    EXPECT_TRUE(hostStructs().contains(name)) << name;
}

TEST(Layouts, ShadersHaveNoOtherStructsInMemory) {
  size_t compared = 0;
  for (const std::string_view shader : vk::shaderNames()) {
    for (const vk::StructLayout& layout : vk::reflect(vk::shaderCodeOf(shader)).structs) {
      if (layout.isBlock) continue;
      ++compared;
      EXPECT_THAT(difference(layout), IsEmpty()) << shader;
    }
  }
  EXPECT_GT(compared, vk::shaderNames().size());
}

TEST(Layouts, DifferencesAreNoticed) {
  const HostStruct host{8, {{"a", 0}, {"b", 4}}};
  const vk::StructLayout same{.name = "S", .bytes = 8, .stride = 8, .members = {{"a", 0, 0}, {"b", 4, 0}}};
  EXPECT_EQ(difference(host, same), "");
  vk::StructLayout other = same;
  other.members[1].offset = 8;
  EXPECT_EQ(difference(host, other), "S::b is at 8, b at 4 on the host");
  other = same;
  std::swap(other.members[0].name, other.members[1].name);
  EXPECT_EQ(difference(host, other), "S::b is at 0, a at 0 on the host");
  other = same;
  other.members.pop_back();
  EXPECT_EQ(difference(host, other), "S has 1 members, 2 on the host");
  other = same;
  other.stride = 16;
  EXPECT_EQ(difference(host, other), "S takes 16 bytes in arrays, 8 on the host");
  other = same;
  other.members[0].matrixStride = 16;
  EXPECT_EQ(difference(host, other), "S::a has columns of 16 bytes");
  EXPECT_EQ(difference(same), "S is in no shared header");
}

}  // namespace
}  // namespace latelight::shared
