#include "vk/object_cache.h"

#include <chrono>
#include <type_traits>

#include "base/parallel.h"

namespace latelight::vk {

namespace {

// A description as bytes (cache key). Two keys are equal if and only if the descriptions are equal.
class Key {
 public:
  template <typename T>
  requires std::is_arithmetic_v<T> || std::is_enum_v<T> || std::is_pointer_v<T> Key& add(const T& value) {
    text_.append(reinterpret_cast<const char*>(&value), sizeof(value));
    return *this;
  }
  Key& add(const std::string& text) {
    add(text.size());
    text_ += text;
    return *this;
  }
  Key& add(const ShaderKey& shader) { return add(shader.name()); }
  Key& add(const Constant& constant) { return add(static_cast<uint32_t>(constant.id)).add(constant.value); }
  Key& add(const VkStencilOpState& s) {
    return add(s.failOp).add(s.passOp).add(s.depthFailOp).add(s.compareOp).add(s.compareMask).add(s.writeMask);
  }
  Key& add(const VertexAttribute& a) { return add(a.location).add(a.format).add(a.offset); }
  Key& add(const VertexBuffer& b) { return add(b.stride).add(b.perInstance).add(b.attributes); }
  template <typename T>
  Key& add(const std::vector<T>& values) {
    add(values.size());
    for (const T& value : values) add(value);
    return *this;
  }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

std::string keyOf(const ComputeDesc& d) {
  return Key()
      .add('c')
      .add(d.shader)
      .add(d.bindings)
      .add(d.sceneSets)
      .add(d.constants)
      .add(d.pushBytes)
      .add(d.code)
      .take();
}

std::string keyOf(const GraphicsDesc& d) {
  Key key;
  key.add('g').add(d.vertex).add(d.fragment).add(d.bindings).add(d.sceneSets).add(d.constants);
  key.add(d.vertexBuffers).add(d.pushBytes).add(d.colors);
  key.add(d.depth).add(d.depthCompare).add(d.depthWrite).add(d.depthClamp).add(d.colorWrite).add(d.blend);
  key.add(d.alphaOnly).add(d.colorsWritten).add(d.samples).add(d.stencil.has_value());
  if (d.stencil) key.add(*d.stencil);
  return key.take();
}

}  // namespace

ObjectCache::~ObjectCache() {
  finish();
}

// Pipelines in creation use the cache, so the lock is released while it waits. Nothing is allocated, because
// destructors call this function after memory ran out. Elements of a map stay where they are.
void ObjectCache::finish() {
  std::unique_lock lock(mutex_);
  for (const auto& each : pipelines_) {
    const std::shared_future<Pipeline> made = each.second;
    lock.unlock();
    // It is not valid if its thread could not be started.
    if (made.valid() && made.wait_for(std::chrono::seconds(0)) != std::future_status::deferred) made.wait();
    lock.lock();
  }
}

template <typename Desc>
PipelineRef ObjectCache::find(std::string key, const Desc& desc, bool now) {
  std::lock_guard lock(mutex_);
  auto& made = pipelines_[std::move(key)];
  if (!made.valid()) {
    if (now) device_.countPipeline();
    const auto make = [this, desc, now] {
      if (!now) device_.countPipeline();
      return makePipeline(device_, desc);
    };
    made = (now ? inBackground(make) : std::async(std::launch::deferred, make)).share();
  }
  return PipelineRef(made);
}

PipelineRef ObjectCache::perhaps(const GraphicsDesc& desc) {
  return find(keyOf(desc), desc, !device_.isCpu());
}

// Pipelines that are requested after the texel window is full load by address.
PipelineRef ObjectCache::pipeline(const ComputeDesc& desc) {
  ComputeDesc completed = desc;
  completed.constants.push_back({kTexelLoadsConstant, device_.memory().isAllInWindow() ? 1u : 0u});
  return find(keyOf(completed), completed, true);
}

PipelineRef ObjectCache::pipeline(const GraphicsDesc& desc) {
  return find(keyOf(desc), desc, true);
}

VkSampler ObjectCache::sampler(const SamplerDesc& desc) {
  std::lock_guard lock(mutex_);
  for (const auto& [known, sampler] : samplers_)
    if (known == desc) return sampler.get();
  return samplers_.emplace_back(desc, makeSampler(device_, desc)).second.get();
}

VkDescriptorSetLayout ObjectCache::setLayout(const std::vector<Binding>& bindings) {
  std::lock_guard lock(mutex_);
  auto& layout = setLayouts_[bindings];
  if (!layout) layout = makeSetLayout(device_, bindings);
  return layout.get();
}

}  // namespace latelight::vk
