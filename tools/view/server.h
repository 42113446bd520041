// The viewer's page and its requests over HTTP, for this machine alone.
#pragma once

#include <functional>
#include <string>

#include "view/viewer.h"

namespace pvol::viewer {

/// Serves on 127.0.0.1 until the process ends, on this port or, if it is 0, on one that is free.
/// Addresses begin with a random token, without which nothing is told, and requests that name
/// another host or come from other pages are refused. Calls `ready` with the page's address once it
/// can be opened. Throws Error where the port is taken.
void serve(Viewer& viewer, int port, const std::function<void(const std::string& address)>& ready);

}  // namespace pvol::viewer
