#include "vk/resources.h"

#include <algorithm>
#include <cassert>
#include <cstring>

#include "base/error.h"
#include "vk/features.h"
#include "vk/texel_window.h"

namespace latelight::vk {

namespace {

template <typename T>
uint64_t number(T object) {
  return reinterpret_cast<uint64_t>(object);
}

constexpr VkImageUsageFlags kAttachment =
    VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;

// Returns the format of the storage view of an sRGB image. sRGB formats do not support storage, so compute shaders
// encode colors themselves.
VkFormat linearFormat(VkFormat format) {
  switch (format) {
    case VK_FORMAT_R8G8B8A8_SRGB:
      return VK_FORMAT_R8G8B8A8_UNORM;
    case VK_FORMAT_B8G8R8A8_SRGB:
      return VK_FORMAT_B8G8R8A8_UNORM;
    default:
      return format;
  }
}

bool isWrittenLinear(const ImageDesc& desc) {
  return (desc.usage & VK_IMAGE_USAGE_STORAGE_BIT) && linearFormat(desc.format) != desc.format;
}

VkImageCreateFlags flagsOf(const ImageDesc& desc) {
  return isWrittenLinear(desc) ? VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT | VK_IMAGE_CREATE_EXTENDED_USAGE_BIT : 0;
}

VkImageView makeView(Device& device, VkImage image, const ImageDesc& desc, VkImageViewType type, uint32_t firstLayer,
                     uint32_t layers, uint32_t levels, bool storage = false) {
  VkImageViewCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
  info.image = image;
  info.viewType = type;
  info.format = storage ? linearFormat(desc.format) : desc.format;
  VkImageViewUsageCreateInfo usage{VK_STRUCTURE_TYPE_IMAGE_VIEW_USAGE_CREATE_INFO};
  constexpr VkImageUsageFlags kStorage = VK_IMAGE_USAGE_STORAGE_BIT;
  usage.usage = storage ? kStorage : desc.usage & ~kStorage;
  if (isWrittenLinear(desc)) info.pNext = &usage;
  // Sampled views cover all layers of an array and have either the depth or the stencil aspect. Attachment views cover
  // single layers and have both aspects.
  VkImageAspectFlags aspect = isDepth(desc.format) ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
  if (hasStencil(desc.format) && type == VK_IMAGE_VIEW_TYPE_2D) aspect |= VK_IMAGE_ASPECT_STENCIL_BIT;
  info.subresourceRange = {aspect, desc.firstLevel(), levels, firstLayer, layers};
  VkImageView view = VK_NULL_HANDLE;
  VK_CHECK(vkCreateImageView(device.get(), &info, nullptr, &view));
  device.setName(VK_OBJECT_TYPE_IMAGE_VIEW, number(view), desc.name.c_str());
  return view;
}

// The size of level 0 of the VkImage.
VkExtent2D baseSize(const ImageDesc& desc) {
  if (desc.oddBase) return {2 * desc.width + 1, 2 * desc.height + 1};
  return {desc.width, desc.height};
}

// Returns true if the host can fill the image in place. This avoids a copy, which a CPU device would execute on a
// single thread.
bool isHostTexture(Device& device, const ImageDesc& desc) {
  constexpr VkImageUsageFlags kTexture =
      VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  if (!device.isCpu() || (desc.usage & ~kTexture) || !(desc.usage & VK_IMAGE_USAGE_SAMPLED_BIT) || desc.layers != 1 ||
      desc.samples != 1 || isDepth(desc.format))
    return false;
  VkImageFormatProperties properties;
  const VkResult result = vkGetPhysicalDeviceImageFormatProperties(device.physical(), desc.format, VK_IMAGE_TYPE_2D,
                                                                   VK_IMAGE_TILING_LINEAR, desc.usage, 0, &properties);
  const VkExtent2D size = baseSize(desc);
  return result == VK_SUCCESS && properties.maxMipLevels >= desc.levels + desc.firstLevel() &&
         properties.maxExtent.width >= size.width && properties.maxExtent.height >= size.height;
}

VkImageCreateInfo imageInfo(const ImageDesc& desc, bool hostTexture) {
  VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
  info.flags = flagsOf(desc);
  info.imageType = VK_IMAGE_TYPE_2D;
  info.format = desc.format;
  const VkExtent2D size = baseSize(desc);
  info.extent = {size.width, size.height, 1};
  info.mipLevels = desc.levels + desc.firstLevel();
  info.arrayLayers = desc.layers;
  info.samples = static_cast<VkSampleCountFlagBits>(desc.samples);
  info.tiling = hostTexture ? VK_IMAGE_TILING_LINEAR : VK_IMAGE_TILING_OPTIMAL;
  info.initialLayout = hostTexture ? VK_IMAGE_LAYOUT_PREINITIALIZED : VK_IMAGE_LAYOUT_UNDEFINED;
  info.usage = desc.usage;
  return info;
}

// Reports a size that the device does not support as the user's error, before the driver crashes.
void checkSize(Device& device, const ImageDesc& desc) {
  const VkPhysicalDeviceLimits& limits = device.properties().limits;
  const uint32_t most = limits.maxImageDimension2D;
  const VkExtent2D size = baseSize(desc);
  if (size.width > most || size.height > most || desc.layers > limits.maxImageArrayLayers)
    fail(ExitCode::Usage, "An image of {}x{} with {} layers ({}) is too large for {}: it allows {}x{} with {} layers.",
         desc.width, desc.height, desc.layers, desc.name, device.info().name, most, most, limits.maxImageArrayLayers);
  VkImageFormatProperties properties;
  const VkResult result =
      vkGetPhysicalDeviceImageFormatProperties(device.physical(), desc.format, VK_IMAGE_TYPE_2D,
                                               VK_IMAGE_TILING_OPTIMAL, desc.usage, flagsOf(desc), &properties);
  if (result != VK_SUCCESS || !(properties.sampleCounts & desc.samples))
    fail(ExitCode::NoDevice, "{} has no {} images with {} samples for usage {:#x} ({}): choose another device.",
         device.info().name, formatName(desc.format), desc.samples, desc.usage, desc.name);
}

VkImage createImage(Device& device, const ImageDesc& desc, bool hostTexture) {
  checkSize(device, desc);
  const VkImageCreateInfo info = imageInfo(desc, hostTexture);
  VkImage image = VK_NULL_HANDLE;
  VK_CHECK(vkCreateImage(device.get(), &info, nullptr, &image));
  return image;
}

BufferDesc completed(BufferDesc desc) {
  if (desc.size == 0) desc.size = 16;
  desc.usage |=
      VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  return desc;
}

VkBufferCreateInfo bufferInfo(Device& device, const BufferDesc& desc) {
  if (desc.size > device.maxBufferSize())
    fail(ExitCode::OutOfMemory,
         "A buffer of {} bytes ({}) is too large for {}, which allows {}: use a smaller image or scene.", desc.size,
         desc.name, device.info().name, device.maxBufferSize());
  VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
  info.size = desc.size;
  info.usage = desc.usage;
  return info;
}

// Buffers that shaders may load lie in the texel window. Those for the host are only copied to.
Allocator::Sharing sharingOf(const BufferDesc& desc) {
  using enum Allocator::Sharing;
  if (desc.exported) return Exported;
  return desc.kind == MemoryKind::Readback ? Blocks : Window;
}

// Returns the types of the external memory to which such a buffer may be bound; 0: none.
VkExternalMemoryHandleTypeFlags externalTypes(Device& device, Allocator::Sharing sharing) {
  if (sharing == Allocator::Sharing::Exported) return VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT;
  return sharing == Allocator::Sharing::Window && device.memory().window() ? TexelWindow::kHandleType : 0;
}

VkBuffer createBuffer(Device& device, const BufferDesc& desc, Allocator::Sharing sharing) {
  VkBufferCreateInfo info = bufferInfo(device, desc);
  VkExternalMemoryBufferCreateInfo external{VK_STRUCTURE_TYPE_EXTERNAL_MEMORY_BUFFER_CREATE_INFO};
  external.handleTypes = externalTypes(device, sharing);
  if (external.handleTypes != 0) info.pNext = &external;
  VkBuffer buffer = VK_NULL_HANDLE;
  VK_CHECK(vkCreateBuffer(device.get(), &info, nullptr, &buffer));
  return buffer;
}

}  // namespace

struct BufferDeletion final : Deletion {
  explicit BufferDeletion(Device& of) : device(of) {}
  ~BufferDeletion() override {
    vkDestroyBuffer(device.get(), buffer, nullptr);
    if (allocation.memory) device.memory().release(allocation);
  }
  Device& device;
  VkBuffer buffer = VK_NULL_HANDLE;
  Allocation allocation;
};

Buffer::Buffer() = default;

// After the delegated constructor, the destructor cleans up if an exception is thrown.
Buffer::Buffer(Device& device, const BufferDesc& desc) : Buffer() {
  device_ = &device;
  desc_ = completed(desc);
  deletion_ = std::make_unique<BufferDeletion>(device);
  const Allocator::Sharing sharing = sharingOf(desc_);
  buffer_ = createBuffer(device, desc_, sharing);
  VkMemoryRequirements needs;
  vkGetBufferMemoryRequirements(device.get(), buffer_, &needs);
  allocation_ = device.memory().allocate(needs, desc_.kind, true, sharing);
  bind(allocation_.memory, allocation_.offset);
}

Buffer::Buffer(Device& device, const BufferDesc& desc, const Heap& heap, VkDeviceSize offset) : Buffer() {
  device_ = &device;
  desc_ = completed(desc);
  deletion_ = std::make_unique<BufferDeletion>(device);
  buffer_ = createBuffer(device, desc_, Allocator::Sharing::Blocks);
  bind(heap.memory(), heap.offset() + offset);
}

void Buffer::bind(VkDeviceMemory memory, VkDeviceSize offset) {
  VK_CHECK(vkBindBufferMemory(device_->get(), buffer_, memory, offset));
  VkBufferDeviceAddressInfo address{VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO};
  address.buffer = buffer_;
  address_ = vkGetBufferDeviceAddress(device_->get(), &address);
  createdAt_ = device_->submissions();
  lifetime_ = std::make_shared<std::byte>();
  device_->setName(VK_OBJECT_TYPE_BUFFER, number(buffer_), desc_.name.c_str());
}

Buffer::Buffer(Buffer&& other) noexcept {
  *this = std::move(other);
}

Buffer& Buffer::operator=(Buffer&& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(desc_, other.desc_);
  std::swap(deletion_, other.deletion_);
  std::swap(lifetime_, other.lifetime_);
  std::swap(buffer_, other.buffer_);
  std::swap(address_, other.address_);
  std::swap(createdAt_, other.createdAt_);
  std::swap(allocation_, other.allocation_);
  return *this;
}

Buffer::~Buffer() {
  if (!buffer_) return;
  lifetime_.reset();  // first: once the buffer is released, another thread may destroy it
  deletion_->buffer = buffer_;
  deletion_->allocation = allocation_;
  device_->deferDeletion(std::move(deletion_));
}

int Buffer::exportMemory() const {
  VkMemoryGetFdInfoKHR info{VK_STRUCTURE_TYPE_MEMORY_GET_FD_INFO_KHR};
  info.memory = allocation_.memory;
  info.handleType = VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT;
  int descriptor = -1;
  VK_CHECK(vkGetMemoryFdKHR(device_->get(), &info, &descriptor));
  return descriptor;
}

// Exported memory does not use VkMemoryDedicatedAllocateInfo, because no known driver requires it for plain buffers.
bool exportsBuffers(const Device& device) {
  if (!device.has(VK_KHR_EXTERNAL_MEMORY_FD_EXTENSION_NAME)) return false;
  VkPhysicalDeviceExternalBufferInfo info{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_EXTERNAL_BUFFER_INFO};
  info.usage = completed({}).usage;
  info.handleType = VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT;
  VkExternalBufferProperties properties{VK_STRUCTURE_TYPE_EXTERNAL_BUFFER_PROPERTIES};
  vkGetPhysicalDeviceExternalBufferProperties(device.physical(), &info, &properties);
  const VkExternalMemoryFeatureFlags features = properties.externalMemoryProperties.externalMemoryFeatures;
  return (features & VK_EXTERNAL_MEMORY_FEATURE_EXPORTABLE_BIT) &&
         !(features & VK_EXTERNAL_MEMORY_FEATURE_DEDICATED_ONLY_BIT);
}

Buffer uploadedBuffer(Device& device, const std::string& name, std::span<const std::byte> bytes,
                      VkBufferUsageFlags usage) {
  Buffer buffer(device, {.size = bytes.size(), .usage = usage, .kind = MemoryKind::Upload, .name = name});
  if (!bytes.empty()) std::memcpy(buffer.mapped(), bytes.data(), bytes.size());
  return buffer;
}

struct ImageDeletion final : Deletion {
  explicit ImageDeletion(Device& of) : device(of) {}
  ~ImageDeletion() override {
    for (VkImageView view : layerViews) vkDestroyImageView(device.get(), view, nullptr);
    for (VkImageView view : {arrayView, storageView}) vkDestroyImageView(device.get(), view, nullptr);
    vkDestroyImage(device.get(), image, nullptr);
    if (allocation.memory) device.memory().release(allocation);
  }
  Device& device;
  VkImage image = VK_NULL_HANDLE;
  VkImageView arrayView = VK_NULL_HANDLE, storageView = VK_NULL_HANDLE;
  std::vector<VkImageView> layerViews;
  Allocation allocation;
};

Image::Image() = default;

Image::Image(Device& device, const ImageDesc& desc) : Image() {
  const bool hostTexture = isHostTexture(device, desc);
  device_ = &device;
  desc_ = desc;
  deletion_ = std::make_unique<ImageDeletion>(device);
  image_ = createImage(device, desc, hostTexture);
  VkMemoryRequirements needs;
  vkGetImageMemoryRequirements(device.get(), image_, &needs);
  using enum Allocator::Sharing;
  allocation_ =
      device.memory().allocate(needs, MemoryKind::Device, hostTexture, desc.usage & kAttachment ? Dedicated : Blocks);
  hostWritable_ = hostTexture && allocation_.mapped;
  bind(allocation_.memory, allocation_.offset);
}

Image::Image(Device& device, const ImageDesc& desc, const Heap& heap, VkDeviceSize offset) : Image() {
  device_ = &device;
  desc_ = desc;
  deletion_ = std::make_unique<ImageDeletion>(device);
  image_ = createImage(device, desc, false);
  bind(heap.memory(), heap.offset() + offset);
}

void Image::bind(VkDeviceMemory memory, VkDeviceSize offset) {
  Device& device = *device_;
  VK_CHECK(vkBindImageMemory(device.get(), image_, memory, offset));
  device.setName(VK_OBJECT_TYPE_IMAGE, number(image_), desc_.name.c_str());
  lifetime_ = std::make_shared<std::byte>();

  constexpr VkImageUsageFlags kViewed = kAttachment | VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT;
  if (!(desc_.usage & kViewed)) return;
  arrayView_ = makeView(device, image_, desc_, VK_IMAGE_VIEW_TYPE_2D_ARRAY, 0, desc_.layers, desc_.levels);
  if (isWrittenLinear(desc_))
    storageView_ = makeView(device, image_, desc_, VK_IMAGE_VIEW_TYPE_2D_ARRAY, 0, desc_.layers, 1, true);
  // The view of an attachment has one level, that of a texture has all.
  const uint32_t levels = desc_.layers == 1 && !(desc_.usage & kAttachment) ? desc_.levels : 1;
  layerViews_.reserve(desc_.layers);  // otherwise, a failed push_back() would leave a view to nobody
  for (uint32_t layer = 0; layer < desc_.layers; ++layer)
    layerViews_.push_back(makeView(device, image_, desc_, VK_IMAGE_VIEW_TYPE_2D, layer, 1, levels));
}

Image::Image(Image&& other) noexcept {
  *this = std::move(other);
}

Image& Image::operator=(Image&& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(desc_, other.desc_);
  std::swap(deletion_, other.deletion_);
  std::swap(lifetime_, other.lifetime_);
  std::swap(image_, other.image_);
  std::swap(arrayView_, other.arrayView_);
  std::swap(storageView_, other.storageView_);
  std::swap(layerViews_, other.layerViews_);
  std::swap(hostWritable_, other.hostWritable_);
  std::swap(allocation_, other.allocation_);
  return *this;
}

Image::~Image() {
  if (!image_) return;
  lifetime_.reset();  // first: once the image is released, another thread may destroy it
  deletion_->image = image_;
  deletion_->arrayView = arrayView_;
  deletion_->storageView = storageView_;
  deletion_->layerViews = std::move(layerViews_);
  deletion_->allocation = allocation_;
  device_->deferDeletion(std::move(deletion_));
}

VkImageAspectFlags Image::aspect() const {
  if (!isDepth(desc_.format)) return VK_IMAGE_ASPECT_COLOR_BIT;
  return VK_IMAGE_ASPECT_DEPTH_BIT | (hasStencil(desc_.format) ? VK_IMAGE_ASPECT_STENCIL_BIT : 0);
}

VkImageView Image::layerView(uint32_t layer) const {
  assert(layer < layerViews_.size());
  return layerViews_[layer];
}

VkMemoryRequirements memoryRequirements(Device& device, const BufferDesc& desc) {
  const VkBufferCreateInfo buffer = bufferInfo(device, completed(desc));
  VkDeviceBufferMemoryRequirements info{VK_STRUCTURE_TYPE_DEVICE_BUFFER_MEMORY_REQUIREMENTS};
  info.pCreateInfo = &buffer;
  VkMemoryRequirements2 needs{VK_STRUCTURE_TYPE_MEMORY_REQUIREMENTS_2};
  vkGetDeviceBufferMemoryRequirements(device.get(), &info, &needs);
  return needs.memoryRequirements;
}

VkMemoryRequirements memoryRequirements(Device& device, const ImageDesc& desc, Placement home) {
  checkSize(device, desc);
  const VkImageCreateInfo image = imageInfo(desc, home == Placement::Own && isHostTexture(device, desc));
  VkDeviceImageMemoryRequirements info{VK_STRUCTURE_TYPE_DEVICE_IMAGE_MEMORY_REQUIREMENTS};
  info.pCreateInfo = &image;
  VkMemoryRequirements2 needs{VK_STRUCTURE_TYPE_MEMORY_REQUIREMENTS_2};
  vkGetDeviceImageMemoryRequirements(device.get(), &info, &needs);
  return needs.memoryRequirements;
}

float maxAnisotropy(const Device& device) {
  return device.features().core.features.samplerAnisotropy ? device.properties().limits.maxSamplerAnisotropy : 1;
}

Handle<VkSampler> makeSampler(Device& device, const SamplerDesc& desc) {
  VkSamplerCreateInfo info{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
  info.magFilter = desc.magnify;
  info.minFilter = desc.minify;
  info.mipmapMode = desc.mip;
  info.addressModeU = desc.wrapU;
  info.addressModeV = desc.wrapV;
  info.addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  info.maxLod = desc.maxLod;
  info.maxAnisotropy = std::min(desc.anisotropy, maxAnisotropy(device));
  info.anisotropyEnable = info.maxAnisotropy > 1;
  VkSampler sampler = VK_NULL_HANDLE;
  VK_CHECK(vkCreateSampler(device.get(), &info, nullptr, &sampler));
  return Handle<VkSampler>(device, sampler);
}

}  // namespace latelight::vk
