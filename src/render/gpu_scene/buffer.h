// A list of records in device memory that mirrors one on the host.
#pragma once

#include <algorithm>
#include <bit>
#include <cstring>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "vk/resources.h"

namespace latelight::render {

// Returns the indices of all elements of a list.
inline std::vector<uint32_t> allOf(size_t count) {
  std::vector<uint32_t> all(count);
  std::iota(all.begin(), all.end(), 0u);
  return all;
}

template <typename T>
class GpuList {
 public:
  GpuList(vk::Device& device, const char* name) : device_(device), name_(name) {}

  // Uploads the whole list. Buffers that frames in flight use live until those frames have finished.
  void upload(vk::Uploader& uploader, std::span<const T> all) {
    reserve(all.size());
    uploader.upload(buffer_, std::as_bytes(all));
  }
  // Uploads the elements with the indices `changed`, in ascending order; `all` may have grown.
  void upload(vk::Uploader& uploader, std::span<const T> all, std::span<const uint32_t> changed) {
    if (all.size() > capacity_) return upload(uploader, all);
    for (size_t i = 0; i < changed.size();) {
      const uint32_t first = changed[i];
      uint32_t end = first;
      while (i < changed.size() && changed[i] == end) ++i, ++end;
      uploader.upload(buffer_, std::as_bytes(all.subspan(first, end - first)), first * sizeof(T));
    }
  }
  // Makes space for a list that shaders write. Earlier contents may be lost.
  void resize(size_t count) { reserve(count); }
  VkDeviceAddress address() const { return buffer_ ? buffer_.address() : 0; }
  const vk::Buffer& buffer() const { return buffer_; }
  size_t capacity() const { return buffer_ ? capacity_ : 0; }

 private:
  void reserve(size_t count) {
    if (buffer_ && count <= capacity_) return;
    // The first allocation has exactly the required capacity; later ones add spare capacity.
    const size_t capacity = buffer_ ? std::bit_ceil(count) : count;
    buffer_ = vk::Buffer(device_, {.size = capacity * sizeof(T), .name = name_});  // may throw
    capacity_ = capacity;
  }
  vk::Device& device_;
  const char* name_;
  vk::Buffer buffer_;
  size_t capacity_ = 0;
};

// Uploads the values if they differ from `last`, those of the last call. If the upload fails, the next call repeats it.
template <typename T>
void uploadChanged(GpuList<T>& list, std::vector<T>& last, std::vector<T>&& values, vk::Uploader& uploader) {
  if (values.size() == last.size() &&
      (values.empty() || std::memcmp(values.data(), last.data(), values.size() * sizeof(T)) == 0))
    return;
  last.clear();
  if (!values.empty()) list.upload(uploader, values);
  last = std::move(values);
}

}  // namespace latelight::render
