// The header fields of all HTTP responses, of the page's files as well as of refusals.
#pragma once

#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>
#include <string_view>

namespace latelight::serve {

using Response = boost::beast::http::response<boost::beast::http::string_body>;

inline constexpr std::string_view kPlainText = "text/plain; charset=utf-8";

// Sets the content's type and the fields that keep other sites, caches and frames away from it.
void setHeader(Response& response, std::string_view type);

}  // namespace latelight::serve
