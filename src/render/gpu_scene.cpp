#include "render/gpu_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "base/log.h"
#include "base/parallel.h"
#include "render/light_tree.h"
#include "render/texture_kinds.h"
#include "shared/color.h"
#include "shared/light.h"

namespace latelight::render {

namespace {

template <typename T>
std::span<const std::byte> bytesOf(const std::vector<T>& values) {
  return std::as_bytes(std::span(values));
}

vk::Buffer makeBuffer(vk::Device& device, const char* name, uint64_t bytes, VkBufferUsageFlags usage = 0) {
  return vk::Buffer(device, {.size = bytes, .usage = usage | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, .name = name});
}

VkSamplerAddressMode addressMode(scene::Wrap wrap) {
  switch (wrap) {
    case scene::Wrap::Repeat:
      return VK_SAMPLER_ADDRESS_MODE_REPEAT;
    case scene::Wrap::Mirror:
      return VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT;
    case scene::Wrap::Clamp:
      return VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  }
  return VK_SAMPLER_ADDRESS_MODE_REPEAT;
}

bool holdsColor(uint32_t slot) {
  return slot == shared::kTextureBaseColor || slot == shared::kTextureEmissive || slot == shared::kTextureSpecularColor;
}

constexpr uint32_t kInstancesAtOnce = 16384;  // a thread's share: waking another costs less

constexpr Sphere kNowhere{glm::vec3(0), -std::numeric_limits<float>::infinity()};  // touches nothing

// Instances by material, then mesh, then their order in the scene: few changes of material, and runs of instances that
// one draw takes.
std::vector<uint32_t> drawOrder(const scene::Scene& scene) {
  std::vector<uint32_t> order(scene.instances.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto before = [&](uint32_t a, uint32_t b) {
    const scene::Instance &x = scene.instances[a], &y = scene.instances[b];
    return std::tie(x.material, x.mesh) < std::tie(y.material, y.mesh);
  };
  if (!std::is_sorted(order.begin(), order.end(), before)) std::stable_sort(order.begin(), order.end(), before);
  return order;
}

// A light without a range has no end: what it gives far away still shows as a highlight on gloss, and in the sum of
// many lights. Any bound on what may be lost in those lets it reach farther than the scene does.
shared::Light deviceLight(const scene::Light& light) {
  shared::Light l{};
  l.position = light.position;
  l.direction = light.direction;
  l.type = light.type;
  l.intensity = light.color * light.intensity;
  l.reach = std::numeric_limits<float>::infinity();
  if (light.type != shared::kLightDirectional) l.reach = light.range.value_or(l.reach);
  if (light.type == shared::kLightSpot) shared::spotCone(light.innerCone, light.outerCone, l.spotScale, l.spotOffset);
  return l;
}

bool isSound(const shared::Light& l) {
  for (const glm::vec3& v : {l.position, l.direction, l.intensity})
    if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z)) return false;
  return !std::isnan(l.reach) && std::isfinite(l.spotScale) && std::isfinite(l.spotOffset);
}

}  // namespace

uint32_t usualAnisotropy(const vk::Device& device) {
  return device.isCpu() ? 1 : 8;
}

GpuScene::GpuScene(vk::Device& device, const scene::Scene& scene)
    : device_(device), scene_(scene), sceneLights_(scene.lights) {
  vk::Uploader uploader(device);
  uploadMeshes(uploader, scene);
  order_ = drawOrder(scene);
  uploadInstances(uploader, {});
  uploadMaterials(uploader, scene);
  uploadLights(uploader);
  uploader.flush();
  makeMaterialSets();
}

void GpuScene::uploadMeshes(vk::Uploader& uploader, const scene::Scene& scene) {
  uint64_t vertices = 0, extras = 0, indices = 0;
  for (const scene::Mesh& mesh : scene.meshes) {
    vertices += mesh.positions.size();
    extras += mesh.extras.size();
    indices += mesh.indices.size();
  }
  positions_ = makeBuffer(device_, "positions", vertices * sizeof(shared::vec3));
  attributes_ = makeBuffer(device_, "attributes", vertices * sizeof(shared::VertexAttributes));
  extras_ = makeBuffer(device_, "extras", extras * sizeof(shared::VertexExtra));
  indices_ = makeBuffer(device_, "indices", indices * sizeof(uint32_t), VK_BUFFER_USAGE_INDEX_BUFFER_BIT);

  std::vector<shared::Mesh>& meshes = meshRecords_;
  vertices = extras = indices = 0;
  for (const scene::Mesh& mesh : scene.meshes) {
    shared::Mesh& m = meshes.emplace_back();
    m.positions = positions_.address() + vertices * sizeof(shared::vec3);
    m.previousPositions = m.nextPositions = m.positions;
    m.attributes = attributes_.address() + vertices * sizeof(shared::VertexAttributes);
    m.extras = mesh.extras.empty() ? 0 : extras_.address() + extras * sizeof(shared::VertexExtra);
    m.indices = indices_.address() + indices * sizeof(uint32_t);
    m.vertexCount = static_cast<uint32_t>(mesh.positions.size());
    m.triangleCount = static_cast<uint32_t>(mesh.indices.size() / 3);
    uploader.upload(positions_, bytesOf(mesh.positions), vertices * sizeof(shared::vec3));
    uploader.upload(attributes_, bytesOf(mesh.attributes), vertices * sizeof(shared::VertexAttributes));
    uploader.upload(extras_, bytesOf(mesh.extras), extras * sizeof(shared::VertexExtra));
    uploader.upload(indices_, bytesOf(mesh.indices), indices * sizeof(uint32_t));
    firstIndices_.push_back(static_cast<uint32_t>(indices));
    vertices += mesh.positions.size();
    extras += mesh.extras.size();
    indices += mesh.indices.size();
  }
  meshes_ = makeBuffer(device_, "meshes", meshes.size() * sizeof(shared::Mesh));
  uploader.upload(meshes_, bytesOf(meshes));
}

void GpuScene::uploadInstances(vk::Uploader& uploader, const scene::Pose& pose) {
  const std::vector<glm::mat4> transforms = scene::instanceTransforms(scene_, pose);
  hostInstances_.resize(order_.size());
  bounds_.resize(order_.size());
  parallelFor(order_.size(), kInstancesAtOnce, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const scene::Instance& instance = scene_.instances[order_[i]];
      const glm::mat4& toWorld = transforms[order_[i]];
      const bool mirrored = glm::determinant(glm::mat3(toWorld)) < 0;
      hostInstances_[i] = {glm::mat4x3(toWorld), instance.mesh, instance.material,
                           instance.id,          instance.part, mirrored ? shared::kInstanceMirrored : 0u};
      const bool hidden = i + 1 < order_.size() && hides(order_[i + 1], order_[i], transforms);
      bounds_[i] = hidden ? kNowhere : boundsOf(instance, toWorld, pose);
    }
  });
  draws_.clear();
  for (uint32_t index = 0; index < hostInstances_.size(); ++index) {
    const shared::Instance& instance = hostInstances_[index];
    const bool mirrored = instance.flags == shared::kInstanceMirrored;
    const bool joins = !draws_.empty() && draws_.back().mirrored == mirrored &&
                       draws_.back().firstIndex == firstIndices_[instance.mesh] &&
                       draws_.back().material == instance.material;
    if (joins)
      ++draws_.back().instanceCount;
    else
      draws_.push_back({index, 1, firstIndices_[instance.mesh],
                        static_cast<uint32_t>(scene_.meshes[instance.mesh].indices.size()), instance.material,
                        mirrored});
  }
  if (!instances_) instances_ = makeBuffer(device_, "instances", hostInstances_.size() * sizeof(shared::Instance));
  uploader.upload(instances_, bytesOf(hostInstances_));
}

// Of the instances as they are, but elsewhere.
vk::Buffer GpuScene::uploadMoved(vk::Uploader& uploader, const scene::Pose& pose, const char* name) const {
  const std::vector<glm::mat4> transforms = scene::instanceTransforms(scene_, pose);
  std::vector<shared::Instance> instances = hostInstances_;
  for (size_t i = 0; i < instances.size(); ++i) instances[i].objectToWorld = glm::mat4x3(transforms[order_[i]]);
  vk::Buffer buffer = makeBuffer(device_, name, instances.size() * sizeof(shared::Instance));
  uploader.upload(buffer, bytesOf(instances));
  return buffer;
}

// Whether an instance is drawn again, after it, where it stands: then nothing of it is ever seen.
bool GpuScene::hides(uint32_t later, uint32_t earlier, const std::vector<glm::mat4>& transforms) const {
  const scene::Instance &a = scene_.instances[later], &b = scene_.instances[earlier];
  return a.mesh == b.mesh && a.material == b.material && transforms[later] == transforms[earlier] &&
         !(scene_.materials[a.material].data.flags & shared::kMaterialBlended);
}

Sphere GpuScene::boundsOf(const scene::Instance& instance, const glm::mat4& toWorld, const scene::Pose& pose) const {
  const scene::Mesh& mesh = scene_.meshes[instance.mesh];
  scene::ReachBox box{mesh.boundsMin, mesh.boundsMax};
  if (mesh.deformation && !pose.empty()) box = deformer_->boundsOf(instance.mesh, pose);
  glm::mat3 linear(toWorld);
  // The largest stretch is at most the Frobenius norm: a sphere that holds the box under any transform.
  float stretch =
      std::sqrt(glm::dot(linear[0], linear[0]) + glm::dot(linear[1], linear[1]) + glm::dot(linear[2], linear[2]));
  return {glm::vec3(toWorld * glm::vec4((box.low + box.high) * 0.5f, 1.0f)),
          glm::length(box.high - box.low) * 0.5f * stretch};
}

scene::Bounds GpuScene::posedBounds() const {
  scene::Bounds all;
  for (const Sphere& sphere : bounds_) {
    all.min = glm::min(all.min, sphere.centre - sphere.radius);
    all.max = glm::max(all.max, sphere.centre + sphere.radius);
  }
  return all;
}

void GpuScene::setPoses(const Poses& poses) {
  const bool posed = !poses.current.empty();
  if (!posed && !posed_) return;
  const bool deforms = std::any_of(scene_.meshes.begin(), scene_.meshes.end(),
                                   [](const scene::Mesh& mesh) { return mesh.deformation != nullptr; });
  if (deforms && !deformer_) deformer_ = std::make_unique<Deformer>(device_, scene_);
  std::vector<shared::Mesh> meshes = meshRecords_;
  if (deforms && posed) {
    deformer_->run(poses);
    deformer_->describe(meshes);
  }
  const bool lightsMove =
      std::any_of(sceneLights_.begin(), sceneLights_.end(), [](const scene::Light& light) { return light.node >= 0; });
  if (lightsMove) std::ranges::copy(scene::posedLights(scene_, poses.current), sceneLights_.begin());
  vk::Uploader uploader(device_);
  uploader.upload(meshes_, bytesOf(meshes));
  uploadInstances(uploader, poses.current);
  previousInstances_ = posed ? uploadMoved(uploader, poses.previous, "previous instances") : vk::Buffer();
  nextInstances_ = posed ? uploadMoved(uploader, poses.next, "next instances") : vk::Buffer();
  if (lightsMove) uploadLights(uploader);
  uploader.flush();
  posed_ = posed;
}

void GpuScene::uploadMaterials(vk::Uploader& uploader, const scene::Scene& scene) {
  for (const scene::Material& material : scene.materials) materials_.push_back(material.data);
  materialBuffer_ = makeBuffer(device_, "materials", materials_.size() * sizeof(shared::Material));
  uploader.upload(materialBuffer_, bytesOf(materials_));
  uploadMaterialUniforms(uploader);
  const bool alike = makesSizesAlike(device_, scene.textures);
  for (const scene::Texture& texture : scene.textures) {
    vk::Image& image = textures_.emplace_back(
        device_, vk::ImageDesc{.format = texture.srgb ? VK_FORMAT_R8G8B8A8_SRGB : VK_FORMAT_R8G8B8A8_UNORM,
                               .width = texture.width,
                               .height = texture.height,
                               .levels = texture.levels,
                               .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                               .name = texture.name,
                               .oddBase = alike && getsOddBase(device_, texture.width, texture.height)});
    uploader.upload(image, {texture.pixels.get(), texture.bytes()});
  }
  // What an empty slot is bound to. Never sampled: Material::textures says which slots hold a texture. A full texture
  // of the slot's usual format and kind of size all the same, so that it makes no combination of its own.
  for (VkFormat format : {VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_R8G8B8A8_SRGB}) {
    vk::Image& empty = emptyTextures_.emplace_back(
        device_, vk::ImageDesc{.format = format,
                               .width = 2,
                               .height = 2,
                               .levels = 2,
                               .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                               .name = "empty",
                               .oddBase = alike});
    static constexpr std::array<std::byte, 5 * 4> kBlack{};
    uploader.upload(empty, kBlack);
  }
}

uint32_t GpuScene::textureSlots() const {
  if (!device_.isCpu()) return ~0u;
  uint32_t slots = 0;
  for (const shared::Material& material : materials_) slots |= material.textures;
  return slots;
}

void GpuScene::uploadMaterialUniforms(vk::Uploader& uploader) {
  const VkDeviceSize alignment = device_.properties().limits.minUniformBufferOffsetAlignment;
  uniformStride_ = (sizeof(shared::Material) + alignment - 1) / alignment * alignment;
  std::vector<std::byte> bytes(materials_.size() * uniformStride_);
  for (size_t i = 0; i < materials_.size(); ++i)
    std::memcpy(&bytes[i * uniformStride_], &materials_[i], sizeof(shared::Material));
  materialUniforms_ = makeBuffer(device_, "material uniforms", bytes.size(), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT);
  uploader.upload(materialUniforms_, bytes);
}

void GpuScene::setAnisotropy(uint32_t samples) {
  if (samples == anisotropy_) return;
  anisotropy_ = samples;
  samplers_.clear();  // nothing is running: submit() waits
  writeMaterialSets();
}

void GpuScene::setLights(std::vector<scene::Light> lights) {
  sceneLights_ = std::move(lights);
  vk::Uploader uploader(device_);
  uploadLights(uploader);
  uploader.flush();
}

void GpuScene::uploadLights(vk::Uploader& uploader) {
  std::vector<shared::Light> lights;
  lights.reserve(sceneLights_.size());
  size_t broken = 0;
  for (uint32_t i = 0; i < sceneLights_.size(); ++i) {
    shared::Light l = deviceLight(sceneLights_[i]);
    broken += !isSound(l);
    l.shadow.x = i;  // the tree reorders lights: carried along, and taken out below
    if (isSound(l) && l.reach > 0 && shared::maxChannel(l.intensity) > 0) lights.push_back(l);
  }
  if (broken) warn("{} of {} lights are left out: a number of theirs is not finite", broken, sceneLights_.size());
  LightTree tree = buildLightTree(lights);
  lightSources_.clear();
  shadowed_.clear();
  for (shared::Light& light : tree.lights) lightSources_.push_back(std::exchange(light.shadow.x, 0u));
  directionalLights_ = tree.directionalLights;
  endlessLights_ = static_cast<uint32_t>(
                       std::ranges::count(tree.lights, std::numeric_limits<float>::infinity(), &shared::Light::reach)) -
                   directionalLights_;
  lightTreeLeaves_ = tree.firstLeaf;
  lights_ = makeBuffer(device_, "lights", tree.lights.size() * sizeof(shared::Light));
  lightTree_ = makeBuffer(device_, "light tree", tree.nodes.size() * sizeof(shared::LightBox));
  uploader.upload(lights_, bytesOf(tree.lights));
  uploader.upload(lightTree_, bytesOf(tree.nodes));
  hostLights_ = std::move(tree.lights);
}

void GpuScene::setShadows(std::span<const LightShadow> shadows) {
  std::vector<LightShadow> changes;
  for (uint32_t light : shadowed_) changes.push_back({light, 0});
  changes.insert(changes.end(), shadows.begin(), shadows.end());
  shadowed_.clear();
  for (const LightShadow& shadow : shadows) shadowed_.push_back(shadow.light);
  for (const LightShadow& change : changes)
    hostLights_[change.light].shadow = {static_cast<uint32_t>(change.maps), static_cast<uint32_t>(change.maps >> 32)};
  vk::Uploader uploader(device_);
  for (const LightShadow& change : changes) {
    const shared::uvec2& shadow = hostLights_[change.light].shadow;
    uploader.upload(lights_, std::as_bytes(std::span(&shadow, 1)),
                    change.light * sizeof(shared::Light) + offsetof(shared::Light, shadow));
  }
  uploader.flush();
}

VkSampler GpuScene::sampler(const scene::Sampler& sampler) {
  for (auto& [known, handle] : samplers_)
    if (known == sampler) return handle.get();
  auto filter = [](scene::Filter f) { return f == scene::Filter::Nearest ? VK_FILTER_NEAREST : VK_FILTER_LINEAR; };
  vk::SamplerDesc desc{
      .magnify = filter(sampler.magnify),
      .minify = filter(sampler.minify),
      .mip = sampler.mip == scene::MipFilter::Linear ? VK_SAMPLER_MIPMAP_MODE_LINEAR : VK_SAMPLER_MIPMAP_MODE_NEAREST,
      .wrapU = addressMode(sampler.wrapU),
      .wrapV = addressMode(sampler.wrapV),
      // Vulkan's way to say "no mip levels" (VkSamplerCreateInfo, note on GL filters)
      .maxLod = sampler.mip == scene::MipFilter::None ? 0.25f : VK_LOD_CLAMP_NONE};
  // Files that ask for blocks of texels, or for no levels, get what they ask for.
  if (desc.magnify == VK_FILTER_LINEAR && desc.minify == VK_FILTER_LINEAR && sampler.mip != scene::MipFilter::None)
    desc.anisotropy = static_cast<float>(anisotropy_);
  return samplers_.emplace_back(sampler, vk::makeSampler(device_, desc)).second.get();
}

void GpuScene::makeMaterialSets() {
  std::vector<vk::Binding> bindings(shared::kTextureCount, vk::Binding::Sampled);
  bindings.push_back(vk::Binding::Uniform);
  materialSetLayout_ = vk::makeSetLayout(device_, bindings);
  const uint32_t count = static_cast<uint32_t>(scene_.materials.size());
  if (count == 0) return;

  const std::array<VkDescriptorPoolSize, 2> sizes{
      {{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, count * shared::kTextureCount},
       {VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, count}}};
  VkDescriptorPoolCreateInfo poolInfo{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                      .maxSets = count,
                                      .poolSizeCount = sizes.size(),
                                      .pPoolSizes = sizes.data()};
  VkDescriptorPool pool;
  VK_CHECK(vkCreateDescriptorPool(device_.get(), &poolInfo, nullptr, &pool));
  materialPool_ = {device_, pool};

  std::vector<VkDescriptorSetLayout> layouts(count, materialSetLayout_.get());
  VkDescriptorSetAllocateInfo setInfo{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                      .descriptorPool = pool,
                                      .descriptorSetCount = count,
                                      .pSetLayouts = layouts.data()};
  materialSets_.resize(count);
  VK_CHECK(vkAllocateDescriptorSets(device_.get(), &setInfo, materialSets_.data()));
  writeMaterialSets();
}

void GpuScene::writeMaterialSets() {
  const uint32_t count = static_cast<uint32_t>(materialSets_.size());
  std::vector<VkDescriptorImageInfo> images;
  images.reserve(count * shared::kTextureCount);
  std::vector<VkDescriptorBufferInfo> uniforms;
  uniforms.reserve(count);
  std::vector<VkWriteDescriptorSet> writes;
  const std::vector<SlotSamplers> samplers = slotSamplers(scene_.materials);
  for (uint32_t i = 0; i < count; ++i) {
    for (uint32_t slot = 0; slot < shared::kTextureCount; ++slot) {
      const int texture = scene_.materials[i].slots[slot].texture;
      const vk::Image& image = texture >= 0 ? textures_[texture] : emptyTextures_[holdsColor(slot)];
      images.push_back(
          {sampler(samplers[i][slot].value_or(scene::Sampler{})), image.view(), VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL});
    }
    writes.push_back({.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                      .dstSet = materialSets_[i],
                      .descriptorCount = shared::kTextureCount,
                      .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                      .pImageInfo = &images[i * shared::kTextureCount]});
    uniforms.push_back({materialUniforms_.get(), i * uniformStride_, sizeof(shared::Material)});
    writes.push_back({.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                      .dstSet = materialSets_[i],
                      .dstBinding = shared::kTextureCount,
                      .descriptorCount = 1,
                      .descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER,
                      .pBufferInfo = &uniforms.back()});
  }
  vkUpdateDescriptorSets(device_.get(), static_cast<uint32_t>(writes.size()), writes.data(), 0, nullptr);
}

std::vector<Draw> GpuScene::visible(const shared::View& view, bool blended, bool atCentres) const {
  const Frustum frustum(view);
  const auto mayShow = [&](const Sphere& bounds) {
    return frustum.touches(bounds) && (!atCentres || frustum.holdsCentre(bounds));
  };
  std::vector<Draw> visible;
  for (const Draw& draw : draws_)
    if (blended == ((materials_[draw.material].flags & shared::kMaterialBlended) != 0))
      appendRuns(draw, mayShow, visible);
  return visible;
}

std::vector<Draw> GpuScene::visibleDraws(const shared::View& view, bool atCentres) const {
  return visible(view, false, atCentres);
}

std::vector<Draw> GpuScene::visibleBlended(const shared::View& view, bool atCentres) const {
  return visible(view, true, atCentres);
}

void GpuScene::appendRuns(const Draw& draw, const std::function<bool(const Sphere&)>& wanted,
                          std::vector<Draw>& runs) const {
  const auto append = [&](std::vector<Draw>& to, size_t own, uint32_t first, uint32_t count) {
    if (to.size() > own && to.back().firstInstance + to.back().instanceCount == first) {
      to.back().instanceCount += count;
      return;
    }
    to.push_back(draw);
    to.back().firstInstance = first;
    to.back().instanceCount = count;
  };
  const auto look = [&](uint32_t begin, uint32_t end, std::vector<Draw>& to, size_t own) {
    for (uint32_t i = draw.firstInstance + begin; i < draw.firstInstance + end; ++i)
      if (wanted(bounds_[i])) append(to, own, i, 1);
  };
  const size_t own = runs.size();  // what comes from here on is this draw's
  if (draw.instanceCount <= kInstancesAtOnce) return look(0, draw.instanceCount, runs, own);
  std::vector<std::vector<Draw>> parts((draw.instanceCount + kInstancesAtOnce - 1) / kInstancesAtOnce);
  parallelFor(draw.instanceCount, kInstancesAtOnce, [&](size_t begin, size_t end) {
    look(static_cast<uint32_t>(begin), static_cast<uint32_t>(end), parts[begin / kInstancesAtOnce], 0);
  });
  for (const std::vector<Draw>& part : parts)
    for (const Draw& run : part) append(runs, own, run.firstInstance, run.instanceCount);
}

void GpuScene::describe(shared::FrameConstants& frame) const {
  frame.instances = instances_.address();
  frame.previousInstances = previousInstances_ ? previousInstances_.address() : instances_.address();
  frame.nextInstances = nextInstances_ ? nextInstances_.address() : instances_.address();
  frame.meshes = meshes_.address();
  frame.materials = materialBuffer_.address();
  frame.lights = lights_.address();
  frame.lightTree = lightTree_.address();
  frame.lightCount = lightCount();
  frame.directionalLights = directionalLights_;
  frame.lightTreeLeaves = lightTreeLeaves_;
}

}  // namespace latelight::render
