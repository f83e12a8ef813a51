// The implementation of the API's Renderer, which several of its sources share.
#pragma once

#include <latelight/latelight.h>

#include <map>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <utility>

#include "api/scene.h"
#include "base/error.h"
#include "base/fork.h"
#include "base/memory.h"
#include "render/submit/renderer.h"
#include "scene/environment/environment.h"
#include "vk/device.h"
#include "vk/shared_timeline.h"

namespace latelight {

struct Renderer::Impl {
  OwnerProcess owner;
  const Scene::Impl& source;
  const scene::Scene& scene;
  std::shared_ptr<vk::Device> device;  // arrays share it
  render::Renderer renderer;
  std::shared_ptr<render::ExportPool> inputs = std::make_shared<render::ExportPool>();  // arrays that others write
  std::optional<vk::SharedTimeline> inputTimeline{};
  std::map<std::string, scene::Environment> environments{};  // of worlds, by name; elements outlive `renderer`'s calls
  // An exception of the callback of whileWaiting() has ended a wait. The callback shares it, which arrays may outlive.
  std::shared_ptr<bool> interrupted = std::make_shared<bool>(false);

  Impl(const Scene::Impl& source, const std::string& selector, const std::optional<scene::Environment>& environment)
      : source(source),
        scene(source.scene),
        device(std::make_shared<vk::Device>(vk::DeviceOptions{.selector = selector})),
        renderer(*device, scene, environment ? &*environment : nullptr) {}

  // One camera and the scene's state at the options' time, for labels.
  struct LabelInput {
    scene::Camera camera;
    render::Settings settings;
    render::SceneState moment;
  };
  // The settings and the scene's state for rays.
  struct RayInput {
    render::Settings settings;
    render::SceneState moment;
  };
  // Fails in any process other than the one that created the renderer.
  RayInput rayInput(const Options& options) const;
  render::WorldCastTicket submitCast(const Worlds& worlds, const WorldRays& rays,
                                     std::vector<render::WorldCast::Target>&& hits, const Options& options);
  // Returns the environments of these names.
  std::vector<const scene::Environment*> environmentsOf(const std::vector<std::string>& names);
  // Fails in any process other than the one that created the renderer.
  LabelInput labelInput(const Camera& camera, const Options& options) const;

  // The cameras of all worlds, world by world, and the scene's state in them.
  struct WorldLabelInput {
    std::vector<scene::Camera> cameras;
    render::Settings settings;
    render::SceneState moment;
  };
  WorldLabelInput worldLabelInput(const Worlds& worlds, const Options& options);
};

// Throws Error(Usage) in the callback of Renderer::whileWaiting(), which interrupts a call of the device's renderer.
void requireIdle(const vk::Device& device);

// Returns the renderer. Fails in any process other than the one that created it, and in the callback of its
// whileWaiting().
template <typename Impl>
Impl& usable(const std::shared_ptr<Impl>& renderer) {
  renderer->owner.require("the renderer");
  requireIdle(*renderer->device);
  return *renderer;
}

// Throws Error(Usage) if the results of a ticket have been taken, or in any process other than the renderer's.
template <typename Impl>
void requireUntaken(const std::shared_ptr<Impl>& ticket) {
  if (!ticket || !ticket->renderer) badUsage("these {} have been taken already", Impl::kResults);
  usable(ticket->renderer);
}

// Returns the result of `take`, a call of a ticket, and releases the ticket's request and renderer. If an exception of
// the callback of whileWaiting() ends the call, the ticket keeps them, and another call continues the wait. The pointer
// is a copy, because the callback may destroy or move the object that holds the ticket.
template <typename TicketImpl, typename Take>
auto taken(const std::shared_ptr<TicketImpl> ticket, Take take) {
  bool& interrupted = *ticket->renderer->interrupted;
  interrupted = false;
  const auto release = [&] {
    { const auto request = std::move(ticket->ticket); }  // destroyed before the renderer
    ticket->renderer.reset();
  };
  try {
    auto result = take(*ticket);
    release();
    return result;
  } catch (const std::bad_alloc&) {
    release();
    failWithoutMemory(TicketImpl::kResults);
  } catch (...) {
    if (!interrupted) release();
    throw;
  }
}

}  // namespace latelight
