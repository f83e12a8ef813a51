// Declaration of the passes and resources of a frame graph, and pass culling.
#include "graph/graph.h"

#include <cassert>
#include <utility>

#include "base/error.h"
#include "graph/use.h"

namespace latelight::graph {
namespace {

// Checks the declaration of a frame. Such errors are bugs of the renderer, and are found before anything is recorded.
void requireFit(const Use use, bool image, const std::string& name) {
  const UseInfo& info = useInfo(use);
  if (image ? info.forImages() : info.forBuffers) return;
  fail(ExitCode::Internal, "frame graph: {} '{}' cannot be used as {}", image ? "image" : "buffer", name, info.name);
}

}  // namespace

const char* name(Stage stage) {
  constexpr const char* kNames[] = {"upload",   "deformation",  "visibility", "shadows", "geometry",
                                    "lighting", "transparency", "post",       "output"};
  return kNames[static_cast<size_t>(stage)];
}

ImageId Graph::create(const vk::ImageDesc& desc) {
  images_.push_back({.desc = desc});
  return {static_cast<uint32_t>(images_.size() - 1)};
}

BufferId Graph::create(const vk::BufferDesc& desc) {
  buffers_.push_back({.desc = desc});
  return {static_cast<uint32_t>(buffers_.size() - 1)};
}

ImageId Graph::import(const vk::Image& image, std::optional<Use> before) {
  if (before) requireFit(*before, true, image.desc().name);
  images_.push_back({.desc = image.desc(), .imported = &image, .before = before});
  return {static_cast<uint32_t>(images_.size() - 1)};
}

BufferId Graph::import(const vk::Buffer& buffer, std::optional<Use> before) {
  if (before) requireFit(*before, false, buffer.desc().name);
  buffers_.push_back({.desc = buffer.desc(), .imported = &buffer, .before = before});
  return {static_cast<uint32_t>(buffers_.size() - 1)};
}

void Graph::pass(Stage stage, std::string_view name, std::vector<Access> accesses, Record record,
                 uint64_t trafficBytes) {
  for (const Access& access : accesses) {
    assert(bool(access.image) != bool(access.buffer));
    require(access);
    if (access.use == Use::HostRead) fail(ExitCode::Internal, "frame graph: HostRead is for exports, not for passes");
    for (const Access& other : accesses) {
      if (!access.image || access.image != other.image) continue;
      if (useInfo(access.use).layout == useInfo(other.use).layout) continue;
      fail(ExitCode::Internal, "frame graph: pass '{}' uses image '{}' as {} and as {}, which need different layouts",
           name, desc(access.image).name, useInfo(access.use).name, useInfo(other.use).name);
    }
  }
  passes_.push_back({stage, std::string(name), std::move(accesses), std::move(record), false, trafficBytes});
}

void Graph::prologue(Stage stage, std::string_view name, Record record) {
  passes_.push_back({stage, std::string(name), {}, std::move(record), true});
}

void Graph::require(const Access& access) {
  if (access.image) {
    vk::ImageDesc& image = images_.at(access.image.index).desc;
    requireFit(access.use, true, image.name);
    image.usage |= useInfo(access.use).imageUsage;
  } else {
    vk::BufferDesc& buffer = buffers_.at(access.buffer.index).desc;
    requireFit(access.use, false, buffer.name);
    buffer.usage |= useInfo(access.use).bufferUsage;
  }
}

void Graph::exports(ImageId image, Use use) {
  require({image, use});
  images_[image.index].exported = use;
}

void Graph::exports(BufferId buffer, Use use) {
  require({buffer, use});
  buffers_[buffer.index].exported = use;
}

const vk::ImageDesc& Graph::desc(ImageId id) const {
  return images_.at(id.index).desc;
}

const vk::BufferDesc& Graph::desc(BufferId id) const {
  return buffers_.at(id.index).desc;
}

// Pass culling by backward liveness analysis: a pass is alive if anything it writes is read by an export or by a later
// live pass. An overwriting use ends the life of the previous contents. Writes of the prologue are not tracked.
std::vector<bool> Graph::alive() const {
  std::vector<bool> images(images_.size()), buffers(buffers_.size()), result(passes_.size());
  for (size_t i = 0; i < images_.size(); ++i) images[i] = images_[i].exported.has_value();
  for (size_t i = 0; i < buffers_.size(); ++i) buffers[i] = buffers_[i].exported.has_value();
  const auto seen = [&](const Access& a) { return a.image ? images[a.image.index] : buffers[a.buffer.index]; };
  for (size_t i = passes_.size(); i-- > 0;) {
    const std::vector<Access>& accesses = passes_[i].accesses;
    result[i] = passes_[i].prologue;
    for (const Access& access : accesses) result[i] = result[i] || (writes(access.use) && seen(access));
    if (!result[i]) continue;
    for (const Access& access : accesses) {
      if (!reads(access.use)) seen(access) = false;
    }
    for (const Access& access : accesses) {
      if (reads(access.use)) seen(access) = true;
    }
  }
  return result;
}

}  // namespace latelight::graph
