#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "graph/graph.h"
#include "graph/use.h"

namespace latelight::graph {
namespace {

// Quotes a string for the DOT language; "\n" in `text` remains a line break.
std::string inQuotes(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '\n') {
      result += "\\n";
      continue;
    }
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + '"';
}

std::string describe(const vk::ImageDesc& desc) {
  std::string text = fmt::format("{}\n{} {}x{}", desc.name, vk::formatName(desc.format), desc.width, desc.height);
  if (desc.layers > 1) text += fmt::format(", {} layers", desc.layers);
  if (desc.levels > 1) text += fmt::format(", {} levels", desc.levels);
  if (desc.samples > 1) text += fmt::format(", {} samples", desc.samples);
  return text;
}

std::string describe(const vk::BufferDesc& desc) {
  return fmt::format("{}\n{} bytes", desc.name, desc.size);
}

// External resources are filled; exported ones have a double outline.
template <typename Nodes>
std::string resources(const Nodes& nodes, char prefix) {
  std::string text;
  for (size_t i = 0; i < nodes.size(); ++i) {
    text += fmt::format("  {}{} [shape=ellipse, label={}{}{}];\n", prefix, i, inQuotes(describe(nodes[i].desc)),
                        nodes[i].imported ? ", style=filled" : "", nodes[i].exported ? ", peripheries=2" : "");
  }
  return text;
}

// The arrow has two heads if the pass writes and keeps earlier contents.
std::string arrow(size_t index, const Access& access) {
  const UseInfo& info = useInfo(access.use);
  const std::string pass = fmt::format("p{}", index);
  const std::string resource =
      access.image ? fmt::format("i{}", access.image.index) : fmt::format("b{}", access.buffer.index);
  return fmt::format("  {} -> {} [label=\"{}\"{}];\n", info.writing ? pass : resource, info.writing ? resource : pass,
                     info.name, info.writing && info.keeps ? ", dir=both" : "");
}

}  // namespace

// Passes of the prologue have a bold outline, culled ones a dashed outline.
std::string Graph::graphviz() const {
  const std::vector<bool> runs = alive();
  std::string text = "digraph frame {\n  rankdir=TB;\n  node [fontname=\"sans-serif\"];\n";
  text += resources(images_, 'i') + resources(buffers_, 'b');
  std::vector<size_t> order(passes_.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_partition(order.begin(), order.end(), [&](size_t i) { return passes_[i].prologue; });
  for (size_t place = 0; place < order.size(); ++place) {
    const size_t i = order[place];
    const char* style = passes_[i].prologue ? ", style=bold" : (runs[i] ? "" : ", style=dashed");
    text += fmt::format("  p{} [shape=box, label={}{}];\n", i, inQuotes(passes_[i].name), style);
    if (place > 0) text += fmt::format("  p{} -> p{} [style=invis];\n", order[place - 1], i);  // the order on the page
    for (const Access& access : passes_[i].accesses) text += arrow(i, access);
  }
  return text + "}\n";
}

}  // namespace latelight::graph
