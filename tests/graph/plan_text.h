// Plans as lines of text, so that tests can state an expected plan.
//
//   "light"                                               a pass that runs
//   "  color: color[Cw] -> frag[T] attachment>readonly"   a barrier before it: stages[accesses] -> ..., layouts
//   "  count: comp[Sw] -> draw[I]"                        of a buffer
//   "  memory: copy[Xw] -> all[R|W]"                      of all memory
//   "end"                                                 the barriers after the last pass follow
#pragma once

#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

#include "graph/graph.h"

namespace latelight::graph {

template <typename Flags>
std::string flagText(Flags flags, const std::vector<std::pair<Flags, const char*>>& names) {
  std::string text;
  for (const auto& [bit, name] : names) {
    if ((flags & bit) == 0) continue;
    text += fmt::format("{}{}", text.empty() ? "" : "|", name);
    flags &= ~bit;
  }
  if (flags) text += "|?";
  return text.empty() ? "-" : text;
}

inline std::string stageText(VkPipelineStageFlags2 stages) {
  return flagText<VkPipelineStageFlags2>(stages, {{VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, "all"},
                                                  {VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, "draw"},
                                                  {VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT, "vert"},
                                                  {VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, "frag"},
                                                  {VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT, "early"},
                                                  {VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT, "late"},
                                                  {VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT, "color"},
                                                  {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, "comp"},
                                                  {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, "copy"},
                                                  {VK_PIPELINE_STAGE_2_HOST_BIT, "host"}});
}

inline std::string accessText(VkAccessFlags2 access) {
  return flagText<VkAccessFlags2>(access, {{VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT, "I"},
                                           {VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT, "Cr"},
                                           {VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT, "Cw"},
                                           {VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT, "Dr"},
                                           {VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT, "Dw"},
                                           {VK_ACCESS_2_SHADER_SAMPLED_READ_BIT, "T"},
                                           {VK_ACCESS_2_SHADER_STORAGE_READ_BIT, "Sr"},
                                           {VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT, "Sw"},
                                           {VK_ACCESS_2_TRANSFER_READ_BIT, "Xr"},
                                           {VK_ACCESS_2_TRANSFER_WRITE_BIT, "Xw"},
                                           {VK_ACCESS_2_HOST_READ_BIT, "H"},
                                           {VK_ACCESS_2_MEMORY_READ_BIT, "R"},
                                           {VK_ACCESS_2_MEMORY_WRITE_BIT, "W"}});
}

inline std::string layoutText(VkImageLayout layout) {
  switch (layout) {
    case VK_IMAGE_LAYOUT_UNDEFINED:
      return "undefined";
    case VK_IMAGE_LAYOUT_GENERAL:
      return "general";
    case VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL:
      return "attachment";
    case VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL:
      return "readonly";
    case VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL:
      return "source";
    case VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL:
      return "target";
    default:
      return "?";
  }
}

inline std::string barrierText(const Graph& graph, const Barrier& barrier) {
  std::string name = "memory";
  if (barrier.image) name = graph.desc(barrier.image).name;
  if (barrier.buffer) name = graph.desc(barrier.buffer).name;
  std::string text =
      fmt::format("  {}: {}[{}] -> {}[{}]", name, stageText(barrier.sourceStage), accessText(barrier.sourceAccess),
                  stageText(barrier.targetStage), accessText(barrier.targetAccess));
  if (barrier.image) text += fmt::format(" {}", layoutText(barrier.oldLayout));
  if (barrier.image && barrier.oldLayout != barrier.newLayout)
    text += fmt::format(">{}", layoutText(barrier.newLayout));
  return text;
}

inline std::vector<std::string> planText(const Graph& graph, const Plan& plan) {
  std::vector<std::string> lines;
  for (const Plan::Step& step : plan.steps) {
    lines.push_back(graph.passName(step.pass));
    for (const Barrier& barrier : step.before) lines.push_back(barrierText(graph, barrier));
  }
  lines.push_back("end");
  for (const Barrier& barrier : plan.after) lines.push_back(barrierText(graph, barrier));
  return lines;
}

}  // namespace latelight::graph
