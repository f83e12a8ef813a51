#include "app/dot.h"

#include <cctype>
#include <stdexcept>

namespace latelight::app {

namespace {

class Reader {
 public:
  explicit Reader(const std::string& text) : text_(text) { advance(); }

  Dot graph() {
    Dot dot;
    if (accept("strict")) {
    }
    dot.directed = accept("digraph");
    if (!dot.directed) expect("graph");
    if (token_ != "{") advance();  // the graph's name
    expect("{");
    while (!accept("}")) statement(dot);
    if (!token_.empty()) fail("the end");
    return dot;
  }

 private:
  [[noreturn]] void fail(const std::string& wanted) const {
    throw std::runtime_error("DOT: " + wanted + " is expected before character " + std::to_string(at_) + ", not '" +
                             token_ + "'");
  }

  // Reads the next token: a name, a quoted string (without quotes, sets `quoted_`) or a symbol; empty at the end.
  void advance() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
    token_.clear();
    quoted_ = false;
    if (at_ == text_.size()) return;
    const auto isName = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '.'; };
    if (text_[at_] == '"') return readString();
    if (isName(text_[at_])) {
      while (at_ < text_.size() && isName(text_[at_])) token_ += text_[at_++];
      return;
    }
    const bool edge = text_.compare(at_, 2, "->") == 0 || text_.compare(at_, 2, "--") == 0;
    token_ = text_.substr(at_, edge ? 2 : 1);
    at_ += token_.size();
  }

  void readString() {
    quoted_ = true;
    for (++at_; at_ < text_.size() && text_[at_] != '"'; ++at_) {
      if (text_[at_] == '\\' && text_.compare(at_, 2, "\\\"") == 0) ++at_;
      token_ += text_[at_];
    }
    if (at_ == text_.size()) fail("a closing quote");
    ++at_;
  }

  bool accept(const char* sign) {
    if (quoted_ || token_ != sign) return false;
    advance();
    return true;
  }
  void expect(const char* sign) {
    if (!accept(sign)) fail(sign);
  }
  std::string id() {
    const bool name = !token_.empty() && (std::isalnum(static_cast<unsigned char>(token_[0])) || token_[0] == '_');
    if (!quoted_ && !name) fail("a name");
    std::string text = token_;
    advance();
    return text;
  }

  std::map<std::string, std::string> attributes() {
    std::map<std::string, std::string> all;
    while (accept("["))
      while (!accept("]")) {
        const std::string name = id();
        expect("=");
        all[name] = id();
        if (!accept(",")) accept(";");
      }
    return all;
  }

  void statement(Dot& dot) {
    const std::string first = id();
    if (accept("=")) {
      id();
    } else if (first == "node" || first == "edge" || first == "graph") {
      attributes();
    } else if (token_ == "->" || token_ == "--") {
      std::string from = first;
      while (accept(dot.directed ? "->" : "--")) {
        const std::string to = id();
        dot.edges.emplace_back(from, to);
        from = to;
      }
      attributes();
    } else {
      dot.nodes[first].merge(attributes());
    }
    accept(";");
  }

  const std::string& text_;
  size_t at_ = 0;
  std::string token_;
  bool quoted_ = false;
};

}  // namespace

std::vector<std::string> Dot::labels() const {
  std::vector<std::string> all;
  for (const auto& [name, attributes] : nodes)
    if (const auto label = attributes.find("label"); label != attributes.end()) all.push_back(label->second);
  return all;
}

Dot parseDot(const std::string& text) {
  return Reader(text).graph();
}

}  // namespace latelight::app
