#include "vk/features.h"

#include <fmt/format.h>

namespace latelight::vk {

Features::Features() {
  core.pNext = &v11;
  v11.pNext = &v12;
  v12.pNext = &v13;
}

#define CORE(name, words)                                                        \
  {                                                                              \
#name, words, [](Features & f) -> VkBool32& { return f.core.features.name; } \
  }
#define LATER(version, name, words)                                        \
  {                                                                        \
#name, words, [](Features & f) -> VkBool32& { return f.version.name; } \
  }

namespace {

constexpr Feature kRequired[] = {
    CORE(shaderInt64, "64-bit integers in shaders"),
    LATER(v12, bufferDeviceAddress, "buffers read by address"),
    LATER(v12, scalarBlockLayout, "structures laid out as in C++"),
    LATER(v12, timelineSemaphore, "submissions waited for by number"),
    LATER(v13, dynamicRendering, "rendering without render pass objects"),
    LATER(v13, synchronization2, "the second synchronization interface"),
    LATER(v13, maintenance4, "Vulkan 1.3's shader interface rules"),
    LATER(v13, shaderDemoteToHelperInvocation, "fragments that go on as helpers"),
    LATER(v13, shaderTerminateInvocation, "fragments that end early"),
};

constexpr Feature kGraphics[] = {
    CORE(independentBlend, "targets that are written or not, each by itself"),
    CORE(geometryShader, "the triangle's number in fragment shaders"),
};

constexpr Feature kCompute[] = {
    CORE(shaderStorageImageWriteWithoutFormat, "storage images of any format"),
    LATER(v12, shaderBufferInt64Atomics, "64-bit atomics in buffers"),
};

constexpr Feature kOptional[] = {
    CORE(samplerAnisotropy, "anisotropic texture filters"),
    CORE(fragmentStoresAndAtomics, "writes from fragment shaders"),
    CORE(depthClamp, "depth clamped instead of clipped"),
    CORE(sampleRateShading, "shading for each sample"),
    CORE(shaderInt16, "16-bit integers in shaders"),
    CORE(shaderFloat64, "64-bit floats in shaders"),
    LATER(v11, multiview, "several views in one draw"),
    LATER(v11, storageBuffer16BitAccess, "16-bit values in buffers"),
    LATER(v12, storageBuffer8BitAccess, "8-bit values in buffers"),
    LATER(v12, shaderFloat16, "16-bit floats in shaders"),
    LATER(v12, shaderInt8, "8-bit integers in shaders"),
    LATER(v12, shaderSharedInt64Atomics, "64-bit atomics in shared memory"),
    LATER(v12, runtimeDescriptorArray, "arrays of textures of any length"),
    LATER(v12, descriptorBindingVariableDescriptorCount, "arrays of textures as long as a scene needs"),
    LATER(v12, descriptorBindingSampledImageUpdateAfterBind, "arrays of very many textures"),
    LATER(v12, shaderSampledImageArrayNonUniformIndexing, "textures by an index of each invocation's own"),
    LATER(v13, subgroupSizeControl, "a chosen subgroup size"),
    LATER(v13, computeFullSubgroups, "full subgroups in compute shaders"),
};

}  // namespace

std::span<const Feature> requiredFeatures() {
  return kRequired;
}
std::span<const Feature> graphicsFeatures() {
  return kGraphics;
}
std::span<const Feature> computeFeatures() {
  return kCompute;
}
std::span<const Feature> optionalFeatures() {
  return kOptional;
}

std::vector<std::string> missingFeatures(std::span<const Feature> features, Features& offered) {
  std::vector<std::string> missing;
  for (const Feature& feature : features)
    if (!feature.of(offered)) missing.push_back(fmt::format("{} ({})", feature.words, feature.name));
  return missing;
}

}  // namespace latelight::vk
