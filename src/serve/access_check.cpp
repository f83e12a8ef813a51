#include "serve/access_check.h"

#include <arpa/inet.h>

#include <algorithm>
#include <utility>

#include "base/error.h"
#include "base/lowercase.h"
#include "serve/token.h"

namespace latelight::serve {

namespace {

bool isAddress(const std::string& text) {
  in6_addr bytes{};
  return inet_pton(AF_INET, text.c_str(), &bytes) == 1 || inet_pton(AF_INET6, text.c_str(), &bytes) == 1;
}

// Returns the host name (RFC 3986, 3.2.2): "localhost" for "LocalHost:8765", "::1" for "[::1]:8765". Returns "" if
// anything other than a port follows.
std::string nameOf(std::string_view host) {
  const bool bracketed = host.starts_with('[');
  const size_t end = std::min(host.find(bracketed ? ']' : ':'), host.size());
  if (bracketed && end == host.size()) return "";
  const std::string name = lowercase(std::string(bracketed ? host.substr(1, end - 1) : host.substr(0, end)));
  const std::string_view port = host.substr(bracketed ? end + 1 : end);
  const bool isPort = port.empty() || (port.starts_with(':') && port.find_first_not_of("0123456789", 1) == port.npos);
  return isPort && (!bracketed || isAddress(name)) ? name : "";
}

// True for names that a browser can send, in lower case: domain names (RFC 952, RFC 1123), and the underscores that
// some local names have. Browsers send other letters in ASCII (RFC 5891).
bool isHostName(const std::string& name) {
  return !name.empty() && name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-_.") == name.npos;
}

// Returns the path of a request's target. Returns "" for the absolute form (RFC 9112, 3.2.2), "http://HOST/PATH", if
// its authority is not that of the field Host, as clients must send it.
std::string_view pathOf(std::string_view target, std::string_view host) {
  constexpr std::string_view kScheme = "http://";
  if (!target.starts_with(kScheme)) return target;
  target.remove_prefix(kScheme.size());
  return target.starts_with(host) ? target.substr(host.size()) : "";
}

}  // namespace

AccessCheck::AccessCheck(std::string token, std::vector<std::string> names)
    : token_(std::move(token)), names_(std::move(names)) {
  for (const std::string& name : names_)
    if (!isHostName(name) && !isAddress(name))
      badUsage("--host-name requires a name without a port, such as render.example.org, not \"{}\"", name);
}

// Protects against DNS rebinding: a site that rebinds its name to this machine still uses that name as the host. An
// address cannot be rebound.
bool AccessCheck::knows(std::string_view host) const {
  const std::string name = nameOf(host);
  return name == "localhost" || isAddress(name) || std::ranges::find(names_, name) != names_.end();
}

AccessCheck::Answer AccessCheck::open(const RequestHeader& header) const {
  if (!knows(header.host)) return {"", "a host name that is not this machine's"};
  if (header.origin && *header.origin != "http://" + std::string(header.host)) return {"", "a page of another origin"};
  std::string_view path = pathOf(header.target, header.host);
  if (!path.starts_with('/')) return {"", "a malformed address"};
  path = path.substr(1, path.find('?') - 1);
  const size_t slash = path.find('/');
  if (slash == std::string_view::npos || !sameToken(path.substr(0, slash), token_)) return {"", "a wrong token"};
  return {std::string(path.substr(slash + 1)), ""};
}

}  // namespace latelight::serve
