// The result of Renderer::submit(): pictures in flight.
#pragma once

#include <memory>
#include <vector>

#include "output/files.h"
#include "render/outputs/exported.h"

namespace latelight::render {

class Renderer;
struct RenderJob;

class Ticket {
 public:
  Ticket(Renderer& renderer, std::shared_ptr<RenderJob> job) : renderer_(&renderer), job_(std::move(job)) {}
  bool done() const;  // take() would not wait for the device
  // Returns the pictures, in the order of their cameras. Waits for them, and copies them from the device if they are
  // there. May be called once, while the renderer lives. Throws errors that occurred after submit().
  std::vector<output::FrameOutput> take();
  // The same for Results::Exported: arrays of all pictures, which stay where they are. They may outlive the renderer,
  // but not its device.
  std::vector<ExportedArray> takeArrays();

 private:
  Renderer* renderer_;
  std::shared_ptr<RenderJob> job_;
};

}  // namespace latelight::render
