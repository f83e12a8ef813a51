#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "graph/graph.h"

namespace latelight::graph {
namespace {

using testing::HasSubstr;
using testing::Not;

// Parses the part of the DOT language that the dump uses, line by line. Fails on anything else.
struct Dot {
  explicit Dot(const std::string& text) {
    std::istringstream stream(text);
    std::string line;
    std::getline(stream, line);
    EXPECT_EQ(line, "digraph frame {");
    const std::regex setting(R"(  rankdir=TB;|  node \[fontname="sans-serif"\];)");
    const std::regex node(R"re(  (\w+) \[(shape=\w+, label="(?:[^"\\]|\\.)*"(?:, \w+=\w+)*)\];)re");
    const std::regex edge(R"re(  (\w+) -> (\w+) \[((?:label="\w+"|style=invis)(?:, dir=both)?)\];)re");
    bool closed = false;
    while (std::getline(stream, line)) {
      std::smatch match;
      EXPECT_FALSE(closed) << "after the end: " << line;
      if (line == "}") {
        closed = true;
      } else if (std::regex_match(line, match, node)) {
        EXPECT_TRUE(nodes.emplace(match[1], match[2]).second) << "twice: " << line;
      } else if (std::regex_match(line, match, edge)) {
        edges.insert(match[1].str() + ">" + match[2].str() + " " + match[3].str());
      } else if (!std::regex_match(line, setting)) {
        ADD_FAILURE() << "not DOT: " << line;
      }
    }
    EXPECT_TRUE(closed);
    for (const std::string& edge : edges) {
      EXPECT_TRUE(nodes.contains(edge.substr(0, edge.find('>')))) << edge;
      EXPECT_TRUE(nodes.contains(edge.substr(edge.find('>') + 1, edge.find(' ') - edge.find('>') - 1))) << edge;
    }
  }
  std::map<std::string, std::string> nodes;  // name -> attributes
  std::set<std::string> edges;               // "from>to attributes"
};

TEST(Graphviz, ShowsPassesResourcesAndWhatIsCulled) {
  Graph graph;
  const ImageId color = graph.create(vk::ImageDesc{
      .format = VK_FORMAT_R16G16B16A16_SFLOAT, .width = 640, .height = 480, .layers = 6, .name = "color"});
  const BufferId out = graph.create(vk::BufferDesc{.size = 1024, .name = "say \"out\" \\ back"});
  const vk::Buffer outside;
  const BufferId scene = graph.import(outside, std::nullopt);
  graph.pass(Stage::Post, "geometry", {{scene, Use::VertexRead}, {color, Use::ColorAttachment}}, {});
  graph.pass(Stage::Post, "debug", {{color, Use::ColorAttachmentLoad}}, {});
  graph.pass(Stage::Post, "copy", {{color, Use::CopySource}, {out, Use::CopyTarget}}, {});
  graph.pass(Stage::Post, "unseen", {{out, Use::StorageRead}}, {});
  graph.exports(out, Use::HostRead);
  const Dot dot(graph.graphviz());
  ASSERT_EQ(dot.nodes.size(), 7u);
  EXPECT_THAT(dot.nodes.at("i0"), HasSubstr(R"(shape=ellipse, label="color\nR16G16B16A16_SFLOAT 640x480, 6 layers")"));
  EXPECT_THAT(dot.nodes.at("b0"), HasSubstr(R"(label="say \"out\" \\ back\n1024 bytes", peripheries=2)"));
  EXPECT_THAT(dot.nodes.at("b1"), HasSubstr("style=filled"));
  EXPECT_THAT(dot.nodes.at("p0"), HasSubstr("shape=box, label=\"geometry\""));
  EXPECT_THAT(dot.nodes.at("p0"), Not(HasSubstr("dashed")));
  EXPECT_THAT(dot.nodes.at("p3"), HasSubstr("style=dashed"));
  EXPECT_THAT(dot.edges, testing::IsSupersetOf({"b1>p0 label=\"VertexRead\"", "p0>i0 label=\"ColorAttachment\"",
                                                "p1>i0 label=\"ColorAttachmentLoad\", dir=both",
                                                "i0>p2 label=\"CopySource\"", "b0>p3 label=\"StorageRead\""}));
}

TEST(Graphviz, ShowsThePrologueFirst) {
  Graph graph;
  const BufferId out = graph.create(vk::BufferDesc{.size = 4, .name = "out"});
  graph.pass(Stage::Post, "write", {{out, Use::StorageWrite}}, {});
  graph.prologue(Stage::Upload, "upload", {});
  graph.exports(out, Use::HostRead);
  const Dot dot(graph.graphviz());
  EXPECT_THAT(dot.nodes.at("p1"), HasSubstr("label=\"upload\", style=bold"));
  EXPECT_THAT(dot.nodes.at("p0"), Not(HasSubstr("style")));
  EXPECT_THAT(dot.edges, testing::Contains("p1>p0 style=invis"));
}

TEST(Graphviz, OfAnEmptyGraphIsAGraph) {
  EXPECT_TRUE(Dot(Graph().graphviz()).nodes.empty());
}

}  // namespace
}  // namespace latelight::graph
