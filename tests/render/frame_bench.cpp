#include "render/frame_bench.h"

#include <cmath>

#include "render/transparency/transparency.h"

namespace latelight::render::test {

FrameBench::FrameBench(vk::Device& device, const scene::Scene& scene, const scene::Environment* environment)
    : device_(device),
      lights_(scene.lights),
      scene_(device, scene),
      environment_(device, environment),
      executor_(device) {
  order_.update(scene_);
}

void FrameBench::shine(uint32_t first, uint32_t count) {
  const auto begin = lights_.begin() + first;
  scene_.setLights({begin, begin + count});
}

FrameContext FrameBench::frame(graph::Graph& graph, const FrameConfig& setup, std::vector<shared::View> views,
                               const BenchLight& light, Overflow* overflow) {
  kept_ = std::make_unique<Kept>();
  kept_->views = std::move(views);
  kept_->viewBuffer = vk::uploadedBuffer(device_, "views", std::as_bytes(std::span(kept_->views)), kViewUsage);
  shared::FrameConstants frame{};
  scene_.describe(frame);
  frame.views = frame.previousViews = frame.nextViews = kept_->viewBuffer.address();
  frame.viewCount = static_cast<uint32_t>(kept_->views.size());
  frame.exposure = light.exposure;
  frame.environmentIntensity = light.environmentIntensity;
  frame.environmentCos = std::cos(light.environmentRotation);
  frame.environmentSin = std::sin(light.environmentRotation);
  frame.environmentLevels = static_cast<float>(environment_.levels());
  kept_->constants = vk::uploadedBuffer(device_, "frame constants", std::as_bytes(std::span(&frame, 1)));
  kept_->visibility = std::make_unique<Visibility>(HardwareVisibility(device_, scene_, order_, kept_->views));
  const shared::vec2 size = kept_->views.front().size;
  FrameContext f{{device_, graph},
                 scene_,
                 environment_,
                 *kept_->visibility,
                 setup,
                 kept_->views,
                 kept_->constants.address(),
                 kept_->viewBuffer.get(),
                 static_cast<uint32_t>(size.x),
                 static_cast<uint32_t>(size.y)};
  f.overflow = overflow;
  return f;
}

const graph::Submission& FrameBench::run(const graph::Graph& graph) {
  return executor_.run(graph, graph.compile());
}

LitFrame addFrame(const FrameContext& f) {
  const LitFrame lit = addOpaque(f);
  addTransparency(f, lit.gbuffer);
  return lit;
}

}  // namespace latelight::render::test
