#include "render/gpu_scene/materials.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <iterator>
#include <utility>

namespace latelight::render {

namespace {

// Those of traitsOf().
constexpr uint32_t kOwnTraits = shared::kTraitPlainUv | shared::kTraitPlainSpecular | shared::kTraitSharedOcclusion;

}  // namespace

GpuMaterials::GpuMaterials(vk::Device& device, const scene::Scene& scene, vk::Uploader& uploader)
    : device_(device),
      scene_(scene),
      textures_(device, scene, uploader),
      opacity_(scene),
      list_(device, "materials"),
      textureSlots_(device.isCpu() ? 0 : ~0u),
      codedTextureSlots_(textureSlots_),
      traits_(device.hasCpuShaders() ? kOwnTraits : 0) {
  const VkDeviceSize alignment = device_.properties().limits.minUniformBufferOffsetAlignment;
  uniformStride_ = (sizeof(shared::Material) + alignment - 1) / alignment * alignment;
  update(uploader, allOf(scene.textures.size()), allOf(scene.materials.size()));
}

namespace {

// Returns a bit per slot whose texture is coded in sRGB.
uint32_t codedSlots(const scene::Scene& scene, const scene::Material& material) {
  uint32_t slots = 0;
  for (uint32_t slot = 0; slot < shared::kTextureCount; ++slot) {
    const int32_t texture = material.slots[slot].texture;
    if (texture >= 0 && scene.textures[texture].srgb) slots |= 1u << slot;
  }
  return slots;
}

}  // namespace

std::vector<std::vector<vk::Binding>> GpuMaterials::setBindings(const vk::Device& device) {
  return {textureBindings(device), {vk::Binding::DynamicUniform}};
}

MaterialSets GpuMaterials::sets(uint32_t material) const {
  return {{textures_.sets().set(baseOf(material)), uniformSet_}, static_cast<uint32_t>(material * uniformStride_)};
}

void GpuMaterials::update(vk::Uploader& uploader, std::span<const uint32_t> textures,
                          std::span<const uint32_t> changed) {
  textures_.update(uploader, textures, changed);
  groupTextures();
  for (const scene::Material& material : scene_.materials) codedTextureSlots_ |= codedSlots(scene_, material);
  const std::vector<uint32_t> followers = opacity_.updateTextures(textures);
  variants_.clear();
  records_.resize(scene_.materials.size());
  std::vector<uint32_t> own, all;
  std::ranges::set_union(changed, followers, std::back_inserter(own));
  std::ranges::set_union(own, withOtherImages(), std::back_inserter(all));
  for (const uint32_t material : all) setRecord(material, scene_.materials[material].data);
  if (!records_.empty()) uploadRecords(uploader, all);
}

// Returns the scene's materials whose records have other indices than their textures, or another group.
std::vector<uint32_t> GpuMaterials::withOtherImages() const {
  std::vector<uint32_t> materials;
  for (uint32_t i = 0; i < scene_.materials.size(); ++i)
    if (!std::ranges::equal(records_[i].images, textures_.indices(i)) ||
        shared::textureGroup(records_[i].textures) != groupOf_[i])
      materials.push_back(i);
  return materials;
}

// Finds the texture groups. Materials that were removed belong to group 0. The number of materials decides whether
// there are too many, because data outputs load only the textures that they depend on, and all outputs take the same
// way.
void GpuMaterials::groupTextures() {
  groupOf_.assign(scene_.materials.size(), 0);
  textureGroups_.clear();
  const auto materials = std::ranges::count(scene_.materials, false, &scene::Material::removed);
  if (!device_.hasCpuShaders() || materials > ptrdiff_t{shared::kMaxTextureGroups}) return;
  std::map<TextureIndices, uint32_t> known;
  for (uint32_t i = 0; i < scene_.materials.size(); ++i) {
    if (scene_.materials[i].removed) continue;
    const auto [group, isNew] = known.try_emplace(textures_.indices(i), static_cast<uint32_t>(known.size()));
    groupOf_[i] = group->second;
    if (isNew) textureGroups_.push_back(i);
  }
}

void GpuMaterials::updateOpacity(vk::Uploader& uploader, std::span<const uint32_t> meshes) {
  const std::vector<uint32_t> changed = opacity_.update(meshes);
  for (const uint32_t material : changed) setRecord(material, scene_.materials[material].data);
  if (changed.empty()) return;
  uploadRecords(uploader, changed);
  variants_.clear();  // they may derive from these
}

void GpuMaterials::pose(vk::Uploader& uploader, const std::map<uint32_t, shared::Material>& posed) {
  std::vector<uint32_t> changed;
  const auto set = [&](uint32_t material, const shared::Material& data) {
    const shared::Material before = records_[material];
    setRecord(material, data);
    if (std::memcmp(&before, &records_[material], sizeof(before)) != 0) changed.push_back(material);
  };
  for (const auto& [material, data] : posed_)
    if (!posed.contains(material)) set(material, scene_.materials[material].data);
  for (const auto& [material, data] : posed) set(material, data);
  posed_ = posed;
  std::ranges::sort(changed);
  if (changed.empty()) return;
  uploadRecords(uploader, changed);
  variants_.clear();  // they may derive from these
}

void GpuMaterials::setVariants(vk::Uploader& uploader, std::vector<Variant> variants) {
  const size_t first = scene_.materials.size();
  if (variants == variants_ && !staleRecords_) return;
  const bool lacksRecords = std::exchange(staleRecords_, true);  // a call after a failure repeats this
  variants_ = std::move(variants);
  records_.resize(first + variants_.size());
  std::vector<uint32_t> changed;
  for (size_t i = 0; i < variants_.size(); ++i) {
    const auto& [base, factors] = variants_[i];
    const auto posed = posed_.find(base);
    shared::Material data = posed != posed_.end() ? posed->second : scene_.materials[base].data;
    data.baseColor = factors.baseColor;
    data.emissive = factors.emissive;
    data.metallic = factors.metallic;
    data.roughness = factors.roughness;
    const auto index = static_cast<uint32_t>(first + i);
    const shared::Material before = records_[index];
    setRecord(index, data);
    if (std::memcmp(&before, &records_[index], sizeof(before)) != 0) changed.push_back(index);
  }
  const uint64_t revision = sceneRevision_;
  staleRecords_ = lacksRecords;
  if (!changed.empty() || staleRecords_) uploadRecords(uploader, changed);
  sceneRevision_ = revision;
}

// A larger list is another buffer, so the records of the scene are uploaded again.
void GpuMaterials::reserveDerived(vk::Uploader& uploader, size_t count) {
  if (records_.size() + count > list_.capacity()) {
    list_.resize(records_.size() + count);
    staleRecords_ = true;
  }
  if (staleRecords_) uploadRecords(uploader, {});
}

GpuMaterials::Derivable GpuMaterials::derivable(uint32_t material) const {
  shared::Material data = records_[material];
  data.baseColor.a = 1;
  return {.flags = data.flags | (scene_.materials[material].data.flags & shared::kMaterialBlended),
          .opaqueTextures = opacity_.isOpaque(material, data)};
}

bool GpuMaterials::anyTranslucent(bool derives) const {
  for (uint32_t i = 0; i < records_.size(); ++i) {
    const bool ofScene = i < scene_.materials.size();
    if (ofScene && scene_.materials[i].removed) continue;
    uint32_t flags = records_[i].flags;
    if (derives && ofScene) flags |= scene_.materials[i].data.flags & shared::kMaterialBlended;
    if (shared::translucent(flags)) return true;
  }
  return false;
}

uint32_t GpuMaterials::baseOf(uint32_t material) const {
  const size_t count = scene_.materials.size();
  return material < count ? material : variants_[material - count].base;
}

namespace {

bool hasTexture(const shared::Material& material, uint32_t slot) {
  return (material.textures >> slot & 1u) != 0;
}

bool hasPlainUv(const shared::Material& material) {
  const auto isPlain = [](const shared::TextureTransform& t) {
    return t.row0 == glm::vec3(1, 0, 0) && t.row1 == glm::vec3(0, 1, 0) && t.uvSet == 0;
  };
  for (uint32_t slot = 0; slot < shared::kTextureCount; ++slot)
    if (hasTexture(material, slot) && !isPlain(material.transforms[slot])) return false;
  return true;
}

bool hasPlainSpecular(const shared::Material& material) {
  return material.specular == 1 && material.specularColor == glm::vec3(1) &&
         !hasTexture(material, shared::kTextureSpecular) && !hasTexture(material, shared::kTextureSpecularColor);
}

bool sharesOcclusion(const shared::Material& material) {
  using namespace shared;  // kTexture*
  if (!hasTexture(material, kTextureOcclusion)) return true;
  const TextureTransform &a = material.transforms[kTextureOcclusion],
                         &b = material.transforms[kTextureMetallicRoughness];
  return hasTexture(material, kTextureMetallicRoughness) &&
         material.images[kTextureOcclusion] == material.images[kTextureMetallicRoughness] && a.row0 == b.row0 &&
         a.row1 == b.row1 && a.uvSet == b.uvSet;
}

// Returns kTrait* of a record that has its flags and images.
uint32_t traitsOf(const shared::Material& material) {
  uint32_t traits = (material.flags & shared::kMaterialPlainUv) ? shared::kTraitPlainUv : 0;
  if (hasPlainSpecular(material)) traits |= shared::kTraitPlainSpecular;
  if (sharesOcclusion(material)) traits |= shared::kTraitSharedOcclusion;
  return traits;
}

}  // namespace

void GpuMaterials::setRecord(uint32_t material, const shared::Material& data) {
  shared::Material& record = records_[material] = data;
  const uint32_t base = baseOf(material);
  std::ranges::copy(textures_.indices(base), record.images);
  record.flags |= scene::layerFlags(record);
  if ((record.flags & shared::kMaterialBlended) && opacity_.isOpaque(base, record))
    record.flags &= ~shared::kMaterialBlended;
  if (hasPlainUv(record)) record.flags |= shared::kMaterialPlainUv;
  textureSlots_ |= record.textures;
  record.textures |= groupOf_[base] << shared::kTextureGroupShift;
  traits_ &= traitsOf(record);
  layers_ |= scene::layersOf(record);
}

void GpuMaterials::uploadRecords(vk::Uploader& uploader, std::span<const uint32_t> changed) {
  std::vector<uint32_t> all;
  if (std::exchange(staleRecords_, true)) changed = all = allOf(records_.size());
  if (!changed.empty()) list_.upload(uploader, records_, changed);
  if (!changed.empty()) uploadUniforms(uploader, changed);
  staleRecords_ = false;
  ++revision_;
  ++sceneRevision_;
}

void GpuMaterials::uploadUniforms(vk::Uploader& uploader, std::span<const uint32_t> changed) {
  std::vector<uint32_t> all;
  if (uniforms_.size() < records_.size() * uniformStride_) {
    const size_t capacity = uniforms_ ? std::bit_ceil(records_.size()) : records_.size();
    setUniforms(vk::Buffer(
        device_,
        {.size = capacity * uniformStride_, .usage = VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, .name = "material uniforms"}));
    all = allOf(records_.size());
    changed = all;
  }
  for (const uint32_t material : changed)
    uploader.upload(uniforms_, std::as_bytes(std::span(&records_[material], 1)), material * uniformStride_);
}

// If a call fails, the earlier buffer and its set remain, and the next call repeats this.
void GpuMaterials::setUniforms(vk::Buffer uniforms) {
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC, 1};
  const VkDescriptorPoolCreateInfo poolInfo{
      .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, .maxSets = 1, .poolSizeCount = 1, .pPoolSizes = &size};
  VkDescriptorPool created = VK_NULL_HANDLE;
  VK_CHECK(vkCreateDescriptorPool(device_.get(), &poolInfo, nullptr, &created));
  vk::Handle<VkDescriptorPool> pool(device_, created);
  const VkDescriptorSetLayout layout = device_.cache().setLayout({vk::Binding::DynamicUniform});
  const VkDescriptorSetAllocateInfo info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                         .descriptorPool = created,
                                         .descriptorSetCount = 1,
                                         .pSetLayouts = &layout};
  VkDescriptorSet set = VK_NULL_HANDLE;
  VK_CHECK(vkAllocateDescriptorSets(device_.get(), &info, &set));
  const VkDescriptorBufferInfo record{uniforms.get(), 0, sizeof(shared::Material)};
  const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                   .dstSet = set,
                                   .descriptorCount = 1,
                                   .descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC,
                                   .pBufferInfo = &record};
  vkUpdateDescriptorSets(device_.get(), 1, &write, 0, nullptr);
  uniforms_ = std::move(uniforms);
  uniformPool_ = std::move(pool);
  uniformSet_ = set;
}

}  // namespace latelight::render
