// Pipelines of shaders, which are referred to by key (shaders.h). Pipelines are created before commands are recorded.
//
// Under validation and in debug builds, descriptions are checked against the shaders (interface_check.h).
//
// Every pipeline has the same layout: push constants (at most 128 bytes, all stages), descriptor set 0 for the images
// of the pass (in binding order), and from set 1 on the sets of a scene (gpu_scene/materials.h). Shaders access buffers
// by address (buffer references).
#pragma once

#include <volk.h>

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "vk/constant_id.h"
#include "vk/device.h"
#include "vk/handle.h"
#include "vk/shaders.h"

namespace latelight::vk {

enum class Binding : uint8_t {
  Sampled,         // combined image sampler
  Storage,         // storage image
  Uniform,         // uniform buffer
  DynamicUniform,  // uniform buffer with an offset that is set when it is bound
  TextureArray,    // bindless textures: an array of combined image samplers, whose length is set when a set is
                   // allocated. It must be the last binding of its set, and requires Device::maxTextureArray() > 0.
};

// The descriptor set of the texel window, after those of a scene that compute shaders have.
inline constexpr uint32_t kTexelSet = 2;

VkDescriptorType descriptorType(Binding binding);

struct Constant {  // specialization constant
  ConstantId id;
  uint32_t value;
};

Handle<VkDescriptorSetLayout> makeSetLayout(Device& device, std::span<const Binding> bindings);

struct Pipeline {
  Handle<VkPipeline> pipeline;
  Handle<VkPipelineLayout> layout;
  VkDescriptorSetLayout set0 = VK_NULL_HANDLE;  // owned by the ObjectCache
  VkDescriptorSet texels = VK_NULL_HANDLE;      // kTexelSet; null: the pipeline does not load texels
  std::vector<Binding> bindings;                // of set 0
  VkPipelineBindPoint point = VK_PIPELINE_BIND_POINT_COMPUTE;
};

struct ComputeDesc {
  ShaderKey shader;
  std::vector<Binding> bindings;
  std::vector<std::vector<Binding>> sceneSets{};  // sets 1 and on
  std::vector<Constant> constants;
  uint32_t pushBytes = 0;  // size of the push constants; 0: not declared, and not checked
  std::string name;
  std::vector<uint32_t> code;  // SPIR-V words to use instead of an embedded shader
};
Pipeline makePipeline(Device& device, const ComputeDesc& desc);

// How colors are blended with existing ones.
enum class Blend : uint8_t {
  Replace,
  Add,         // all channels, including alpha, are added
  Over,        // premultiplied over operator
  SumAndOver,  // colors are added, alpha is blended as by Over
};

struct VertexAttribute {
  uint32_t location;
  VkFormat format;
  uint32_t offset;  // bytes, from the start of the element
  bool operator==(const VertexAttribute&) const = default;
};
struct VertexBuffer {
  uint32_t stride;   // bytes; 0: all vertices read the same element
  bool perInstance;  // one element per instance, else one per vertex
  std::vector<VertexAttribute> attributes;
};

struct GraphicsDesc {
  std::string vertex;  // vertex shaders have no variants
  ShaderKey fragment;
  std::vector<VertexBuffer> vertexBuffers;  // by binding
  std::vector<Binding> bindings;
  std::vector<std::vector<Binding>> sceneSets;  // sets 1 and on
  std::vector<Constant> constants;              // for both stages
  uint32_t pushBytes = 0;                       // see ComputeDesc
  std::vector<VkFormat> colors;
  uint32_t colorsWritten = ~0u;  // bit i: color i is written
  VkFormat depth = VK_FORMAT_UNDEFINED;
  VkCompareOp depthCompare = VK_COMPARE_OP_GREATER;  // depth is reversed
  bool depthWrite = true;
  bool depthClamp = false;                  // requires the optional feature
  std::optional<VkStencilOpState> stencil;  // for both faces; the reference value is dynamic. `depth` must have stencil
  bool colorWrite = true;
  Blend blend = Blend::Replace;
  bool alphaOnly = false;  // of the colors, only alpha is written
  uint32_t samples = 1;
  std::string name;
};
Pipeline makePipeline(Device& device, const GraphicsDesc& desc);

}  // namespace latelight::vk
