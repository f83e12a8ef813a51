// The transient pool: what submissions take for a graph's transients and give back.
#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "graph/graph.h"

namespace latelight::graph {

// A resource and what was asked for: it may round its own description up.
template <typename Resource, typename Desc>
struct Pooled {
  Pooled(vk::Device& device, const Desc& desc) : desc(desc), resource(device, desc) {}
  Desc desc;
  Resource resource;
  uint64_t lastUse = 0;  // the pool's count of submissions
};
using PooledImage = Pooled<vk::Image, vk::ImageDesc>;
using PooledBuffer = Pooled<vk::Buffer, vk::BufferDesc>;

// Any thread may give back.
class TransientPool {
 public:
  explicit TransientPool(vk::Device& device) : device_(device) {}
  // A submission begins: frees what none of the last few took (pictures of another size, a graph that ran once).
  void tick();
  std::unique_ptr<PooledImage> take(const vk::ImageDesc& desc);
  std::unique_ptr<PooledBuffer> take(const vk::BufferDesc& desc);
  void giveBack(std::unique_ptr<PooledImage> image);
  void giveBack(std::unique_ptr<PooledBuffer> buffer);

 private:
  vk::Device& device_;
  std::mutex mutex_;
  uint64_t now_ = 0;  // submissions so far
  std::vector<std::unique_ptr<PooledImage>> images_;
  std::vector<std::unique_ptr<PooledBuffer>> buffers_;
};

}  // namespace latelight::graph
