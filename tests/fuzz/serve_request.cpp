// HTTP requests to `latelight serve`: the parser with the server's limits, then the check of access. A request whose
// token, host or origin is wrong must never be granted.
#include <boost/asio/buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <string>

#include "fuzz/fuzz.h"
#include "serve/access_check.h"
#include "serve/page.h"

using namespace latelight;

namespace {

namespace http = boost::beast::http;
constexpr std::string_view kToken = "0123456789abcdef0123456789abcdef";

std::string_view view(boost::beast::string_view text) {
  return {text.data(), text.size()};
}

void checkAccess(const http::request<http::empty_body>& request) {
  static const serve::AccessCheck check{std::string(kToken), {"render.example"}};
  if (request.count(http::field::host) > 1 || request.count(http::field::origin) > 1) return;  // as in connection.cpp
  serve::RequestHeader header{view(request.target()), view(request[http::field::host]), {}};
  if (request.find(http::field::origin) != request.end()) header.origin = view(request[http::field::origin]);
  const serve::AccessCheck::Answer answer = check.open(header);
  if (answer.refusal.empty()) {
    const std::string absolute = "http://" + std::string(header.host);
    const size_t path = header.target.starts_with(absolute) ? absolute.size() : 0;
    if (header.target.find(kToken) != path + 1) fuzz::report("granted without the token");
    if (header.host.find("evil") != header.host.npos) fuzz::report("granted to a host of another name");
    if (header.origin && header.origin->find(header.host) == header.origin->npos) fuzz::report("granted to a page");
    serve::findPageFile(answer.path);
  }
  boost::beast::websocket::is_upgrade(request);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  http::request_parser<http::empty_body> parser;
  parser.header_limit(8192);
  parser.body_limit(0);
  parser.eager(true);
  boost::beast::error_code error;
  for (size_t at = 0; at < size && !error && !parser.is_done();) {
    const size_t used = parser.put(boost::asio::buffer(data + at, size - at), error);
    if (used == 0) break;
    at += used;
  }
  if (!error && parser.is_header_done()) checkAccess(parser.get());
  return 0;
}
