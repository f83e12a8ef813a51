#include "render/visibility/draw.h"

#include <algorithm>
#include <cstddef>

#include "render/gbuffer/layout.h"

namespace latelight::render {

namespace {

VkRenderingAttachmentInfo attachment(VkImageView view, VkImageLayout layout, VkAttachmentLoadOp load,
                                     VkAttachmentStoreOp store) {
  return {.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
          .imageView = view,
          .imageLayout = layout,
          .loadOp = load,
          .storeOp = store};
}

// Bindings of the vertex buffers of scene draws.
constexpr uint32_t kPositions = 0, kAttributes = 1, kInstances = 2;  // the views are binding 3

bool alphaTests(const shared::Material& material) {
  return (material.flags & shared::kMaterialMasked) != 0 || shared::translucent(material.flags);
}

const vk::PipelineRef& pipelineOf(const ScenePipelines& pipelines, const shared::Material& material, bool vast) {
  if (pipelines.layered && (material.flags & shared::kMaterialLayered)) return *pipelines.layered;
  if (vast) return alphaTests(material) ? *pipelines.vastMasked : *pipelines.vastOpaque;
  return alphaTests(material) ? pipelines.masked : pipelines.opaque;
}

}  // namespace

DeviceDraws::DeviceDraws(vk::Device& device, std::vector<DrawList> lists) {
  size_t count = 0;
  for (const DrawList& list : lists) count += list.instances.size();
  instances_ = vk::Buffer(device, {.size = count * sizeof(uint32_t),
                                   .usage = VK_BUFFER_USAGE_VERTEX_BUFFER_BIT,
                                   .kind = vk::MemoryKind::Upload,
                                   .name = "instances to draw"});
  uint32_t first = 0;
  for (DrawList& list : lists) {
    for (Draw& draw : list.draws) draw.first += first;
    std::copy(list.instances.begin(), list.instances.end(), instances_.as<uint32_t>() + first);
    first += static_cast<uint32_t>(list.instances.size());
    draws_.push_back(std::move(list.draws));
  }
}

bool DeviceDraws::empty() const {
  return std::all_of(draws_.begin(), draws_.end(), [](const std::vector<Draw>& list) { return list.empty(); });
}

std::vector<vk::VertexBuffer> sceneVertexBuffers(const std::string& vertexShader) {
  using shared::VertexAttributes;
  constexpr uint32_t kColumn = sizeof(glm::vec3), kProjection = offsetof(shared::View, projection);
  constexpr uint32_t kPrincipal = kProjection + offsetof(shared::Projection, X);
  constexpr uint32_t kKind = kProjection + offsetof(shared::Projection, kind);
  std::vector<vk::VertexBuffer> buffers{{sizeof(shared::VertexPosition), false, {{0, VK_FORMAT_R32G32B32_SFLOAT, 0}}},
                                        {sizeof(VertexAttributes), false, {}},
                                        {sizeof(uint32_t), true, {{4, VK_FORMAT_R32_UINT, 0}}},
                                        {0,
                                         true,
                                         {{5, VK_FORMAT_R32G32B32_SFLOAT, 0},
                                          {6, VK_FORMAT_R32G32B32_SFLOAT, kColumn},
                                          {7, VK_FORMAT_R32G32B32_SFLOAT, 2 * kColumn},
                                          {8, VK_FORMAT_R32G32B32_SFLOAT, offsetof(shared::View, eye)},
                                          {9, VK_FORMAT_R32G32B32A32_SFLOAT, kProjection},
                                          {10, VK_FORMAT_R32G32_SFLOAT, kPrincipal},
                                          {11, VK_FORMAT_R32_UINT, kKind},
                                          {12, VK_FORMAT_R32G32B32_SFLOAT, offsetof(shared::View, eyeLow)}}}};
  if (vertexShader != "scene_depth.vert" && vertexShader != "scene_triangle.vert")
    buffers[kAttributes].attributes = {{1, VK_FORMAT_R32G32B32_SFLOAT, offsetof(VertexAttributes, normal)},
                                       {2, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(VertexAttributes, tangent)},
                                       {3, VK_FORMAT_R32G32_SFLOAT, offsetof(VertexAttributes, uv0)}};
  return buffers;
}

vk::GraphicsDesc forVast(vk::GraphicsDesc desc) {
  // A vertex of a vast triangle loads its whole triangle by address, so the vertex streams stay at their first element.
  for (const uint32_t stream : {kPositions, kAttributes}) {
    desc.vertexBuffers[stream].stride = 0;
    desc.vertexBuffers[stream].perInstance = true;
  }
  desc.constants.push_back({kVastDrawConstant, 1});
  desc.name += " vast";
  return desc;
}

ScenePipelines scenePipelines(const FrameContext& f, const vk::GraphicsDesc& opaque, const vk::GraphicsDesc& masked) {
  vk::Device& device = f.device;
  const auto completed = [&](vk::GraphicsDesc desc, uint32_t isMasked) {
    if (desc.vertex.empty()) desc.vertex = "scene.vert";
    desc.vertexBuffers = sceneVertexBuffers(desc.vertex);
    if (desc.pushBytes == 0) desc.pushBytes = sizeof(shared::DrawPush);
    desc.fragment = materialVariant(device, desc.fragment);
    desc.sceneSets = GpuMaterials::setBindings(device);
    desc.constants.push_back({kAlphaMaskedConstant, isMasked});
    if (isMasked) desc.name += " masked";
    return desc;
  };
  ScenePipelines pipelines{device.cache().pipeline(completed(opaque, 0)), device.cache().perhaps(completed(masked, 1))};
  if (!f.scene.anyVast()) return pipelines;
  pipelines.vastOpaque = device.cache().perhaps(forVast(completed(opaque, 0)));
  pipelines.vastMasked = device.cache().perhaps(forVast(completed(masked, 1)));
  return pipelines;
}

ScenePipelines scenePipelines(const FrameContext& f, const vk::GraphicsDesc& desc) {
  return scenePipelines(f, desc, desc);
}

DrawnView drawnView(const FrameContext& f, uint32_t view) {
  return {f.constantsOf(view), f.viewBuffer, view, f.scene.instancesOf(f.views[view].world).address};
}

SceneBinder::SceneBinder(graph::Context& context, const GpuScene& scene, const DeviceDraws& draws,
                         const DrawnView& view, const ScenePipelines& pipelines, std::span<const vk::BoundImage> images)
    : context_(context),
      scene_(scene),
      push_{.frame = view.frame, .instances = view.instances, .view = view.view},
      pipelines_(pipelines),
      images_(images) {
  const VkBuffer buffers[] = {draws.instances(), view.views};
  const VkDeviceSize offsets[] = {0, view.view * sizeof(shared::View)};
  vkCmdBindVertexBuffers(context.get(), kInstances, 2, buffers, offsets);
}

const vk::Pipeline& SceneBinder::bind(const Draw& draw) {
  VkCommandBuffer commands = context_.get();
  const shared::Material& material = scene_.materials().record(draw.material);
  const vk::Pipeline& pipeline = pipelineOf(pipelines_, material, draw.vast).get();
  if (bound_ != &pipeline) {
    context_.commands().bind(pipeline, images_, std::as_bytes(std::span(&push_, 1)));
    bound_ = &pipeline;
    material_ = ~0u;
  }
  if (material_ != draw.material) {
    const MaterialSets bound = scene_.materials().sets(draw.material);
    context_.commands().bindSceneSets(pipeline, bound.sets, std::span(&bound.offset, 1));
    const bool doubleSided = (material.flags & shared::kMaterialDoubleSided) != 0;
    vkCmdSetCullMode(commands, doubleSided ? VK_CULL_MODE_NONE : VK_CULL_MODE_BACK_BIT);
    material_ = draw.material;
  }
  if (mesh_ != draw.mesh) {
    const VertexStreams streams = scene_.geometry().streams(draw.mesh);
    const VkBuffer buffers[] = {streams.positions, streams.attributes};
    const VkDeviceSize offsets[] = {streams.firstPosition, streams.firstAttribute};
    vkCmdBindVertexBuffers(commands, kPositions, 2, buffers, offsets);
    vkCmdBindIndexBuffer(commands, scene_.geometry().indexBuffer(draw.mesh), 0, VK_INDEX_TYPE_UINT32);
    mesh_ = draw.mesh;
  }
  vkCmdSetFrontFace(commands, draw.clockwise ? VK_FRONT_FACE_CLOCKWISE : VK_FRONT_FACE_COUNTER_CLOCKWISE);
  return pipeline;
}

void recordDraw(graph::Context& context, const GpuScene& scene, const Draw& draw) {
  if (draw.vast) {
    vkCmdDraw(context.get(), shared::kVastFan * scene.geometry().indexCount(draw.mesh), draw.count, 0, draw.first);
    return;
  }
  vkCmdDrawIndexed(context.get(), scene.geometry().indexCount(draw.mesh), draw.count, 0, 0, draw.first);
}

graph::ImageId addScreenDepth(const FrameContext& f, graph::Stage stage, const char* name, const char* shader,
                              graph::ImageId from) {
  Bindings bindings(f.device, graph::Use::SampledFragment);
  bindings.sampled(from);
  vk::GraphicsDesc desc;
  desc.vertex = "screen.vert";
  desc.fragment = shader;
  desc.bindings = bindings.kinds();
  desc.pushBytes = sizeof(uint32_t);
  desc.depth = kDepthFormat;
  desc.depthCompare = VK_COMPARE_OP_ALWAYS;
  desc.name = name;
  const vk::PipelineRef pipeline = f.device.cache().pipeline(desc);
  const graph::ImageId depth = createTarget(f, kDepthFormat, name);
  f.graph.pass(stage, name, {{depth, graph::Use::DepthAttachment}, {from, graph::Use::SampledFragment}},
               [=](graph::Context& context) {
                 for (uint32_t view = 0; view < f.viewCount(); ++view) {
                   const ViewRendering rendering(context, f, view, {}, {depth, true});
                   context.commands().bind(pipeline.get(), bindings.images(context), view);
                   recordScreen(context);
                 }
               });
  return depth;
}

graph::ImageId attachableDepth(const FrameContext& f, graph::ImageId depth) {
  if (vk::isDepth(f.graph.desc(depth).format)) return depth;
  return addScreenDepth(f, graph::Stage::Transparency, "depth copy", "depth_copy.frag", depth);
}

void recordScreen(graph::Context& context) {
  vkCmdSetFrontFace(context.get(), VK_FRONT_FACE_COUNTER_CLOCKWISE);
  vkCmdSetCullMode(context.get(), VK_CULL_MODE_NONE);
  vkCmdDraw(context.get(), 3, 1, 0, 0);
}

// --- rendering -------------------------------------------------------------------------------------------------------

namespace {

// Triangles per rendering. Smaller ones of large scenes take longer (docs/experiments.md, "Vertices and rasterization
// at once").
constexpr uint64_t kLeastInPart = 4096, kMostInPart = 16384, kParts = 16;

void keepContents(VkRenderingAttachmentInfo& target) {
  if (target.loadOp == VK_ATTACHMENT_LOAD_OP_CLEAR) target.loadOp = VK_ATTACHMENT_LOAD_OP_LOAD;
}

}  // namespace

ViewRendering::ViewRendering(graph::Context& context, const FrameContext& f, uint32_t view,
                             std::span<const graph::ImageId> colors, DepthUse depth, ColorUse use, uint32_t written)
    : context_(context),
      hasStencil_(vk::hasStencil(context.image(depth.image).desc().format)),
      extent_{f.width, f.height},
      overlaps_(f.device.hasCpuShaders()) {
  const VkAttachmentLoadOp load = use == ColorUse::Clear ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD;
  for (size_t i = 0; i < colors.size(); ++i) {
    const bool wanted = (written >> i & 1u) != 0;
    colors_.push_back(attachment(context.image(colors[i]).layerView(view), VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
                                 wanted ? load : VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                 wanted ? VK_ATTACHMENT_STORE_OP_STORE : VK_ATTACHMENT_STORE_OP_DONT_CARE));
  }
  const VkImageView depthView = context.image(depth.image).layerView(view);
  depth_ = depth.clear ? attachment(depthView, VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL, VK_ATTACHMENT_LOAD_OP_CLEAR,
                                    VK_ATTACHMENT_STORE_OP_STORE)
                       : attachment(depthView, VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL, VK_ATTACHMENT_LOAD_OP_LOAD,
                                    VK_ATTACHMENT_STORE_OP_NONE);
  begin(extent_);
  const VkRect2D area{{0, 0}, extent_};
  const VkViewport viewport{
      0, static_cast<float>(f.height), static_cast<float>(f.width), -static_cast<float>(f.height), 0, 1};
  vkCmdSetViewport(context.get(), 0, 1, &viewport);
  vkCmdSetScissor(context.get(), 0, 1, &area);
}

ViewRendering::~ViewRendering() {
  vkCmdEndRendering(context_.get());
}

void ViewRendering::begin(VkExtent2D extent) {
  VkRenderingInfo rendering{.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                            .renderArea = {{0, 0}, extent},
                            .layerCount = 1,
                            .colorAttachmentCount = static_cast<uint32_t>(colors_.size()),
                            .pColorAttachments = colors_.data(),
                            .pDepthAttachment = &depth_};
  if (hasStencil_) rendering.pStencilAttachment = &depth_;
  vkCmdBeginRendering(context_.get(), &rendering);
}

// Begins another rendering if these triangles are too many for the current one. An empty one of another area makes
// lavapipe rasterize what was recorded.
void ViewRendering::makeSpace(uint32_t triangles) {
  if (recorded_ > 0 && recorded_ + triangles > inPart_) {
    for (VkRenderingAttachmentInfo& color : colors_) keepContents(color);
    keepContents(depth_);
    vkCmdEndRendering(context_.get());
    begin({1, 1});
    vkCmdEndRendering(context_.get());
    begin(extent_);
    recorded_ = 0;
  }
  recorded_ += triangles;
}

// Draws instance after instance, as one draw does.
void ViewRendering::drawInParts(const GpuScene& scene, const vk::Pipeline& pipeline, const Draw& draw) {
  const auto pushFirst = [&](uint32_t triangle) {
    vkCmdPushConstants(context_.get(), pipeline.layout.get(), VK_SHADER_STAGE_ALL,
                       offsetof(shared::DrawPush, firstTriangle), sizeof(triangle), &triangle);
  };
  const uint32_t triangles = scene.geometry().indexCount(draw.mesh) / 3;
  const uint32_t together = std::max(1u, inPart_ / triangles);  // instances
  for (uint32_t instance = 0; instance < draw.count; instance += together) {
    const uint32_t count = std::min(together, draw.count - instance);
    for (uint32_t first = 0; first < triangles; first += inPart_) {
      const uint32_t part = std::min(inPart_, triangles - first);
      makeSpace(part * count);
      if (triangles > part) pushFirst(first);
      vkCmdDrawIndexed(context_.get(), 3 * part, count, 3 * first, 0, draw.first + instance);
    }
  }
  if (triangles > inPart_) pushFirst(0);
}

void ViewRendering::draw(const GpuScene& scene, SceneBinder& binder, const std::vector<Draw>& draws) {
  uint64_t indices = 0;
  for (const Draw& draw : draws) indices += uint64_t{scene.geometry().indexCount(draw.mesh)} * draw.count;
  inPart_ = static_cast<uint32_t>(std::clamp(indices / 3 / kParts, kLeastInPart, kMostInPart));
  for (const Draw& draw : draws) {
    const vk::Pipeline& pipeline = binder.bind(draw);
    if (overlaps_ && !draw.vast && scene.geometry().indexCount(draw.mesh) > 0)
      drawInParts(scene, pipeline, draw);
    else
      recordDraw(context_, scene, draw);
  }
}

void recordClear(graph::Context& context, const FrameContext& f, uint32_t view,
                 std::span<const graph::ImageId> colors) {
  std::vector<VkRenderingAttachmentInfo> targets;
  for (const graph::ImageId color : colors)
    targets.push_back(attachment(context.image(color).layerView(view), VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
                                 VK_ATTACHMENT_LOAD_OP_CLEAR, VK_ATTACHMENT_STORE_OP_STORE));
  const VkRenderingInfo rendering{.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                  .renderArea = {{0, 0}, {f.width, f.height}},
                                  .layerCount = 1,
                                  .colorAttachmentCount = static_cast<uint32_t>(targets.size()),
                                  .pColorAttachments = targets.data()};
  vkCmdBeginRendering(context.get(), &rendering);
  vkCmdEndRendering(context.get());
}

}  // namespace latelight::render
