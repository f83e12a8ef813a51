// Buffers and images, with dedicated memory or placed in a heap. They are move-only, and their destruction is deferred
// (Device::deferDeletion).
#pragma once

#include <volk.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "vk/device.h"
#include "vk/memory.h"

namespace latelight::vk {

struct BufferDeletion;
struct ImageDeletion;

struct BufferDesc {
  VkDeviceSize size = 0;                                          // in bytes; 0 is treated as 16
  VkBufferUsageFlags usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;  // device address and transfer are always added
  MemoryKind kind = MemoryKind::Device;
  std::string name;
  bool exported = false;  // other APIs can import it: exportMemory()
  bool operator==(const BufferDesc&) const = default;
};

// Returns true if buffers of the device can be exported.
bool exportsBuffers(const Device& device);

class Buffer {
 public:
  Buffer();
  Buffer(Device& device, const BufferDesc& desc);
  // Places the buffer in a heap, at an offset; it is never mapped. memoryRequirements() returns its size.
  Buffer(Device& device, const BufferDesc& desc, const Heap& heap, VkDeviceSize offset);
  Buffer(Buffer&&) noexcept;
  Buffer& operator=(Buffer&&) noexcept;
  ~Buffer();

  VkBuffer get() const { return buffer_; }
  VkDeviceAddress address() const { return address_; }
  VkDeviceSize size() const { return desc_.size; }
  const BufferDesc& desc() const { return desc_; }
  std::byte* mapped() const { return allocation_.mapped; }  // null unless host visible
  template <typename T>
  T* as() const {
    return reinterpret_cast<T*>(allocation_.mapped);
  }
  explicit operator bool() const { return buffer_ != VK_NULL_HANDLE; }
  // Returns the memory of an exported buffer as an opaque file descriptor, which the caller owns. The buffer is the
  // only resource in it.
  int exportMemory() const;
  VkDeviceSize memorySize() const { return allocation_.size; }  // in bytes; importers require it
  // True if nothing was submitted since the buffer was created, so that nothing in flight uses it.
  bool isNew() const { return createdAt_ == device_->submissions(); }
  std::weak_ptr<const void> lifetime() const { return lifetime_; }  // expires before the buffer is released

 private:
  void bind(VkDeviceMemory memory, VkDeviceSize offset);
  Device* device_ = nullptr;
  BufferDesc desc_;
  std::unique_ptr<BufferDeletion> deletion_;
  std::shared_ptr<const void> lifetime_;
  uint64_t createdAt_ = 0;
  VkBuffer buffer_ = VK_NULL_HANDLE;
  VkDeviceAddress address_ = 0;
  Allocation allocation_;  // none in a heap
};

// Returns a buffer in host-visible memory, initialized with these bytes.
Buffer uploadedBuffer(Device& device, const std::string& name, std::span<const std::byte> bytes,
                      VkBufferUsageFlags usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);

struct ImageDesc {
  VkFormat format = VK_FORMAT_UNDEFINED;
  uint32_t width = 1, height = 1;
  uint32_t layers = 1;  // array layers: one per view for a frame's targets
  uint32_t levels = 1;  // mip levels
  uint32_t samples = 1;
  VkImageUsageFlags usage = 0;
  std::string name;
  // For a texture: adds an unused mip level below level 0, with odd width and height. Size, levels, views and uploads
  // exclude it.
  bool oddBase = false;
  bool operator==(const ImageDesc&) const = default;
  uint32_t firstLevel() const { return oddBase ? 1 : 0; }  // level of the VkImage that is level 0 here
};

class Image {
 public:
  Image();
  Image(Device& device, const ImageDesc& desc);
  // Places the image in a heap, at an offset; the host never writes it. memoryRequirements() returns its size.
  Image(Device& device, const ImageDesc& desc, const Heap& heap, VkDeviceSize offset);
  Image(Image&&) noexcept;
  Image& operator=(Image&&) noexcept;
  ~Image();

  VkImage get() const { return image_; }
  const ImageDesc& desc() const { return desc_; }
  VkImageAspectFlags aspect() const;
  VkImageView arrayView() const { return arrayView_; }  // 2D_ARRAY, all layers and levels
  // The same view for writes by compute shaders. An sRGB image is written without conversion: the shaders encode its
  // colors.
  VkImageView storageView() const { return storageView_ ? storageView_ : arrayView_; }
  VkImageView layerView(uint32_t layer) const;       // 2D, one layer, level 0: for attachments and textures
  VkImageView view() const { return layerView(0); }  // 2D, layer 0; all levels if layers == 1
  explicit operator bool() const { return image_ != VK_NULL_HANDLE; }

  // Textures of a CPU device have linear tiling, and the host may write them in place until their first layout
  // transition. takeHostWrite() returns true once, for the writer; the layout is then VK_IMAGE_LAYOUT_PREINITIALIZED.
  bool takeHostWrite() const { return std::exchange(hostWritable_, false); }
  std::byte* mapped() const { return allocation_.mapped; }
  std::weak_ptr<const void> lifetime() const { return lifetime_; }  // expires before the image is released

 private:
  void bind(VkDeviceMemory memory, VkDeviceSize offset);
  Device* device_ = nullptr;
  ImageDesc desc_;
  std::unique_ptr<ImageDeletion> deletion_;
  std::shared_ptr<const void> lifetime_;
  VkImage image_ = VK_NULL_HANDLE;
  VkImageView arrayView_ = VK_NULL_HANDLE, storageView_ = VK_NULL_HANDLE;
  std::vector<VkImageView> layerViews_;
  Allocation allocation_;  // none in a heap
  mutable bool hostWritable_ = false;
};

// Returns the memory requirements of a resource, with dedicated memory or placed in a heap, without creating it.
enum class Placement : uint8_t { Own, Heap };
VkMemoryRequirements memoryRequirements(Device& device, const BufferDesc& desc);
VkMemoryRequirements memoryRequirements(Device& device, const ImageDesc& desc, Placement home);

struct SamplerDesc {
  VkFilter magnify = VK_FILTER_LINEAR, minify = VK_FILTER_LINEAR;
  VkSamplerMipmapMode mip = VK_SAMPLER_MIPMAP_MODE_LINEAR;
  VkSamplerAddressMode wrapU = VK_SAMPLER_ADDRESS_MODE_REPEAT, wrapV = VK_SAMPLER_ADDRESS_MODE_REPEAT;
  float maxLod = VK_LOD_CLAMP_NONE;
  float anisotropy = 1;  // maximum samples along a pixel's footprint, within the device's limit
  bool operator==(const SamplerDesc&) const = default;
};
// For texelFetch, which requires a bound sampler but ignores it.
inline constexpr SamplerDesc kNearestSampler{VK_FILTER_NEAREST, VK_FILTER_NEAREST, VK_SAMPLER_MIPMAP_MODE_NEAREST};
Handle<VkSampler> makeSampler(Device& device, const SamplerDesc& desc);
float maxAnisotropy(const Device& device);  // 1 if the device has no anisotropic filtering

// How an Uploader transfers data to the device.
enum class UploadMode : uint8_t {
  Direct,    // host-visible destinations (CPU devices) are written in place, by all cores; others are staged
  Staged,    // all destinations are staged, as on a device with its own memory
  Deferred,  // as Direct, but destinations that a submission in flight may use are staged and wait for record()
};

// Copies host data to the device. upload() copies the data before it returns, either in place or to staging memory of
// 16 MiB (Deferred: 64 MiB), and calls flush() when that memory is full. flush() (or the destructor, which turns an
// error into a warning) submits the staged copies and waits. Images end in VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL.
// A pending copy whose destination is destroyed is dropped, so that callers may replace a buffer or an image at any
// time. In Deferred mode, the destructor drops all pending copies.
class Uploader {
 public:
  explicit Uploader(Device& device, UploadMode mode = UploadMode::Direct);
  ~Uploader();
  void upload(const Buffer& to, std::span<const std::byte> data, VkDeviceSize offset = 0);
  // `data`: all levels in sequence, level 0 first, tightly packed; one layer.
  void upload(const Image& to, std::span<const std::byte> data);
  void flush();

  // In Deferred mode, record() replaces flush(): it records the staged copies as part of another submission, after
  // which forget() drops them. Work recorded after record() must wait for the copies.
  bool empty() const { return batches_.empty(); }
  void record(VkCommandBuffer commands) const;
  void forget();

 private:
  struct Copy;
  struct Source {
    VkBuffer buffer;
    VkDeviceSize offset;
  };
  // Copies data to staging memory, at a multiple of `alignment`; flushes first if the memory is full.
  Source stage(std::span<const std::byte> data, VkDeviceSize alignment);
  void writeInPlace(const Image& to, std::span<const std::byte> data);
  Copy& add(Copy copy);
  Device& device_;
  UploadMode mode_;
  std::vector<std::vector<Copy>> batches_;  // copies of a batch write to different locations, so their order does not
                                            // matter
  std::vector<Buffer> staging_;             // the last one is being filled
  VkDeviceSize used_ = 0;                   // used bytes of the last staging buffer
  VkDeviceSize pending_ = 0;                // used bytes of the others
};

// Bytes per texel of an uncompressed color or depth format in a buffer; for D24S8 and D32S8 only the depth.
uint32_t texelBytes(VkFormat format);
const char* formatName(VkFormat format);  // "R8G8B8A8_SRGB"
// The type of a format's values, as in its name. Formats of depth, with or without stencil, have a kind of their own.
enum class FormatKind { Unorm, Snorm, Uint, Sfloat, Ufloat, Srgb, Depth };
FormatKind formatKind(VkFormat format);
// Returns the number of color channels, without the exponent that those of E5B9G9R9 share; 1 for formats of depth.
uint32_t channelCount(VkFormat format);
bool isDepth(VkFormat format);
bool hasStencil(VkFormat format);

}  // namespace latelight::vk
