#include "view/server.h"

#include <fmt/format.h>
#include <httplib.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>

#include "pvol/error.h"
#include "view/page_files.h"

namespace pvol::viewer {
namespace {

using cli::Json;
using httplib::Request;
using httplib::Response;

constexpr const char* kHost = "127.0.0.1";
constexpr const char* kJson = "application/json";
/// A page asks again for news after this time, so that threads do not wait for pages that are gone.
constexpr double kLongestWait = 5;

/// 128 random bits.
std::string make_token() {
  std::random_device random;
  return fmt::format("{:08x}{:08x}{:08x}{:08x}", random(), random(), random(), random());
}

/// Answers with what `work` returns, or with what it throws as {"error": ...}.
template <class Work>
void answer(Response& to, const Work& work) {
  Json json;
  try {
    json = work();
  } catch (const Error& e) {
    to.status = 400;
    json = {{"error", e.what()}};
  } catch (const Json::exception& e) {
    to.status = 400;
    json = {{"error", std::string("the request cannot be read: ") + e.what()}};
  } catch (const std::exception& e) {
    to.status = 500;
    json = {{"error", std::string("it failed: ") + e.what()}};
  }
  to.set_content(cli::to_text(json), kJson);
}

double number_of(const Request& from, const char* name, double otherwise) {
  const std::string text = from.get_param_value(name);
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  return !text.empty() && *end == 0 ? number : otherwise;
}

ViewChoice choice_of(const Request& from) {
  const double exposure = number_of(from, "exposure", from.has_param("exposure") ? NAN : 0);
  if (!std::isfinite(exposure)) {
    throw Error(fmt::format("exposure: found '{}', expected a number of stops",
                            from.get_param_value("exposure")));
  }
  ViewChoice choice{.display = {.exposure = exposure}};
  if (from.has_param("layer")) choice.layer = from.get_param_value("layer");
  if (from.has_param("tone_map")) choice.display.tone_map = from.get_param_value("tone_map");
  return choice;
}

/// The picture as bytes of red, green and blue, its size and scale in the header.
void send_picture(const Viewer& viewer, const Request& from, Response& to) {
  View view;
  try {
    view = viewer.picture(choice_of(from), from.get_param_value("filtered") == "true");
  } catch (const std::exception& e) {
    to.status = 400;
    return to.set_content(e.what(), "text/plain");
  }
  if (view.picture.rgb.empty()) {
    to.status = 204;
    return;
  }
  to.set_header("X-Width", std::to_string(view.picture.width));
  to.set_header("X-Height", std::to_string(view.picture.height));
  if (view.has_scale) to.set_header("X-Scale", fmt::format("{:.6g} {:.6g}", view.lo, view.hi));
  const auto& rgb = view.picture.rgb;
  to.set_content(reinterpret_cast<const char*>(rgb.data()), rgb.size(), "application/octet-stream");
}

/// Whether a request is for this server and comes from its own page or from none: names of other
/// hosts may be made to lead here by other pages.
bool is_ours(const Request& request, int port) {
  const auto is_own = [&](const std::string& host) {
    const std::string end = port == 80 ? "" : fmt::format(":{}", port);
    return host == kHost + end || host == "localhost" + end;
  };
  if (!is_own(request.get_header_value("Host"))) return false;
  const std::string origin = request.get_header_value("Origin");
  constexpr std::string_view kScheme = "http://";
  return origin.empty() || (origin.starts_with(kScheme) && is_own(origin.substr(kScheme.size())));
}

void set_headers(httplib::Server& server) {
  server.set_default_headers(
      {{"Cache-Control", "no-store"},
       {"Content-Security-Policy", "default-src 'self'; img-src 'self' data:"},
       {"Cross-Origin-Resource-Policy", "same-origin"},
       {"Referrer-Policy", "no-referrer"},
       {"X-Content-Type-Options", "nosniff"}});
}

/// Browsers keep connections open, each of which takes a thread: there are enough for several
/// pages.
void set_limits(httplib::Server& server) {
  constexpr std::size_t kThreads = 32, kLargestRequest = 1 << 20;
  server.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
  server.set_keep_alive_timeout(1);
  server.set_payload_max_length(kLargestRequest);
  server.set_tcp_nodelay(true);
  server.set_error_handler([](const Request&, Response& to) {
    if (to.status != 413) return;
    to.set_content(cli::to_text(Json{{"error", "the request is larger than a MiB"}}), kJson);
  });
}

void add_page(httplib::Server& server, const std::string& root) {
  for (const PageFile& file : page_files()) {
    const std::string name = std::string_view(file.name) == "index.html" ? "" : file.name;
    server.Get(root + name, [&file](const Request&, Response& to) {
      to.set_content(file.text.data(), file.text.size(), file.type);
    });
  }
}

void add_requests(httplib::Server& server, const std::string& root, Viewer& viewer) {
  server.Get(root + "scene",
             [&](const Request&, Response& to) { answer(to, [&] { return viewer.describe(); }); });
  server.Post(root + "scene", [&](const Request& from, Response& to) {
    answer(to, [&] { return viewer.change(Json::parse(from.body)); });
  });
  server.Get(root + "state", [&](const Request& from, Response& to) {
    const double after = number_of(from, "after", 0);
    constexpr double kMost = 0x1p53;
    const auto number = std::uint64_t(after > 0 ? std::min(after, kMost) : 0);
    answer(to, [&] { return viewer.state(number, kLongestWait); });
  });
  server.Get(root + "picture",
             [&](const Request& from, Response& to) { send_picture(viewer, from, to); });
  server.Get(root + "pixel", [&](const Request& from, Response& to) {
    answer(to, [&] {
      return viewer.pixel(number_of(from, "across", -1), number_of(from, "down", -1));
    });
  });
  server.Post(root + "save", [&](const Request& from, Response& to) {
    answer(to, [&] { return viewer.save(Json::parse(from.body)); });
  });
}

}  // namespace

void serve(Viewer& viewer, int port, const std::function<void(const std::string& address)>& ready) {
  httplib::Server server;
  // A port that was left a moment ago may be taken again; one that is in use may not be shared.
  server.set_socket_options([](socket_t socket) {
    const int yes = 1;
    (void)setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  const int bound =
      port == 0 ? server.bind_to_any_port(kHost) : (server.bind_to_port(kHost, port) ? port : -1);
  if (bound < 0) {
    throw Error(
        fmt::format("port {} cannot be opened; choose another one with --port, or 0", port));
  }
  const std::string root = "/" + make_token() + "/";
  set_headers(server);
  set_limits(server);
  server.set_pre_routing_handler([&](const Request& from, Response& to) {
    if (is_ours(from, bound) && from.path.starts_with(root)) {
      return httplib::Server::HandlerResponse::Unhandled;
    }
    to.status = 404;
    to.set_header("Connection", "close");  // a body that was not read is no request
    return httplib::Server::HandlerResponse::Handled;
  });
  add_page(server, root);
  add_requests(server, root, viewer);
  ready(fmt::format("http://{}:{}{}", kHost, bound, root));
  if (!server.listen_after_bind()) throw Error("the viewer's connections cannot be served");
}

}  // namespace pvol::viewer
