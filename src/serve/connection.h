// An HTTP connection: it serves the files of the page, or upgrades to a WebSocket.
#pragma once

#include <boost/asio/ip/tcp.hpp>

#include "serve/hub.h"

namespace latelight::serve {

// Starts an object that lives as long as its connection.
void startConnection(boost::asio::ip::tcp::socket socket, Hub& hub);

}  // namespace latelight::serve
