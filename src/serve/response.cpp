#include "serve/response.h"

#include <boost/beast/core/string.hpp>

namespace latelight::serve {

namespace http = boost::beast::http;

namespace {

// Content security policy: the page may load its own files and connect to its own server, and no other site may frame
// or read it.
constexpr const char* kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

}  // namespace

void setHeader(Response& response, std::string_view type) {
  response.set(http::field::content_type, boost::beast::string_view(type.data(), type.size()));
  response.set("Content-Security-Policy", kPolicy);
  response.set("Referrer-Policy", "no-referrer");
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Cross-Origin-Resource-Policy", "same-origin");
  response.set("Cross-Origin-Opener-Policy", "same-origin");
  response.set(http::field::cache_control, "no-store");
}

}  // namespace latelight::serve
