// What Renderer::submit() returns: pictures on their way.
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
  // The pictures, in the order of their cameras; waits for them, and brings them from the device where they were left
  // there. Once, while the renderer lives. What went wrong on the way is thrown here.
  std::vector<output::FrameOutput> take();
  // The same of Results::Exported: arrays of all pictures, which stay where they are. They may outlive the renderer,
  // but not its device.
  std::vector<ExportedArray> takeArrays();

 private:
  Renderer* renderer_;
  std::shared_ptr<RenderJob> job_;
};

}  // namespace latelight::render
