// The return value of Renderer::submit(): pictures in flight.
#pragma once

#include <memory>

#include "render/submit/result.h"

namespace latelight::render {

class Renderer;
struct RenderJob;

class Ticket {
 public:
  Ticket(Renderer& renderer, std::shared_ptr<RenderJob> job) : renderer_(&renderer), job_(std::move(job)) {}
  bool done() const;                     // take() would not wait for the device
  std::vector<float> exposures() const;  // the factors of the pictures' radiance; before take()
  // Waits for the pictures and returns them. Those of Results::OnDevice are copied from the device first; arrays of
  // Results::Exported stay where they are, and may outlive the renderer, but not its device. May be called once, while
  // the renderer lives. Throws errors that occurred after submit().
  RenderResult take();
  // Waits until shaders have placed the worlds, and returns their kWorld* bits; none unless they did.
  std::vector<uint32_t> worldStatus() const;

 private:
  Renderer* renderer_;
  std::shared_ptr<RenderJob> job_;
};

}  // namespace latelight::render
