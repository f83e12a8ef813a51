// A reader of the DOT language (graphviz.org/doc/info/lang.html), without subgraphs, ports and HTML strings.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace latelight::app {

struct Dot {
  bool directed = false;
  std::map<std::string, std::map<std::string, std::string>> nodes;  // attributes by node
  std::vector<std::pair<std::string, std::string>> edges;
  std::vector<std::string> labels() const;
};

// Throws std::runtime_error with the position of the first syntax error.
Dot parseDot(const std::string& text);

}  // namespace latelight::app
