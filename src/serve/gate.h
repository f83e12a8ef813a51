// Who is let in: every request, for a page or for a session, passes here first.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace latelight::serve {

// What a request says of itself.
struct Knock {
  std::string_view target;                 // "/TOKEN/style.css"
  std::string_view host;                   // "localhost:8765"
  std::optional<std::string_view> origin;  // of requests that a page makes: "http://localhost:8765"
};

class Gate {
 public:
  // `names`: those that this machine has for browsers, beside "localhost" and addresses.
  Gate(std::string token, std::vector<std::string> names);

  struct Answer {
    std::string path;     // what follows the token: "", "style.css"
    std::string refusal;  // why not, in a few words; empty: come in
  };
  Answer open(const Knock& knock) const;

 private:
  bool knows(std::string_view host) const;

  std::string token_;
  std::vector<std::string> names_;
};

}  // namespace latelight::serve
