// pvol.compare and pvol.trade.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <memory>
#include <string>

#include "pvol/error.h"
#include "python/bind.h"
#include "python/cancellable.h"
#include "python/requests.h"
#include "python/studies.h"
#include "python/warn.h"

namespace pvol::python {
namespace {

py::object parse_json(const std::string& text) {
  return py::module_::import("json").attr("loads")(text);
}

std::shared_ptr<const Picture> picture_of(const py::object& picture) {
  if (py::isinstance<Picture>(picture)) return picture.cast<std::shared_ptr<Picture>>();
  return std::make_shared<const Picture>(read_picture(picture.cast<std::filesystem::path>()));
}

py::object compare(const py::object& a, const py::object& b) {
  const auto film_a = picture_of(a), film_b = picture_of(b);
  return parse_json(cancellable([&](const Stop&) { return compare_text(*film_a, *film_b); }));
}

/// A value as command lines write it: words bare, lists with commas.
std::string plain(py::handle value) {
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>() ? "on" : "off";
  return py::str(value);
}

std::vector<Variant> variants_of(const py::object& given) {
  std::vector<Variant> all;
  if (given.is_none()) return all;
  for (const py::handle item : given) {
    Variant& variant = all.emplace_back();
    for (const auto& [key, value] : item.cast<py::dict>()) {
      variant.emplace_back(py::str(key), plain(value));
    }
  }
  if (all.empty())
    throw Error("variants: found none; leave them out to measure all variants of pvol-stats trade");
  return all;
}

py::object trade(const py::object& scene, const py::object& variants, double budget,
                 std::uint32_t spp, const py::kwargs& settings) {
  const TradeRequest request{request_of(scene, settings), variants_of(variants), budget, spp};
  const TradeRows rows =
      cancellable([&](const Stop& stop) { return measure_trade(request, stop); });
  warn(rows.warnings);
  return parse_json(rows.text);
}

constexpr const char* kCompareText =
    R"(Whether two pictures differ by more than noise, and by how much.

Parameters
----------
a, b : Picture or path of an .exr
    Of the same view, with other seeds.

Returns
-------
dict
    The output of `pvol-stats image --json`: by channel and in luminance means, bias with its
    standard error and interval, RMSE, the part of the MSE that noise explains, and a verdict on
    bias with its p-value.)";

constexpr const char* kTradeText = R"(Costs and gains of the renderer's settings, measured in turn.

Parameters
----------
scene, **settings
    As for `render`; pictures are measured at 96 x 96 pixels or so.
variants : sequence of dicts, optional
    Options of the renderer to set, as [{"depth": 0}, {"tracker": "delta", "depth": 4}]. Default:
    everything that `pvol-stats trade` measures, one at a time.
budget : float
    Seconds of the clock.
most_samples : int
    Maximum number of samples per pixel in each round, and sixteen times as many for the reference;
    it may end the measurement before the budget does. 0: as many as the budget allows.

Returns
-------
list of dicts
    The default first: "setting", "time", "variance" and "time_x_variance" (ratios to the default
    with intervals), "counts", "bytes", "bias" against the reference, "on_front"; or why it was
    "left_out". As in `pvol-stats trade --json`.)";

}  // namespace

void bind_studies(py::module_& m) {
  m.def("compare", &compare, py::arg("a"), py::arg("b"), kCompareText);
  m.def("trade", &trade, py::arg("scene"), py::arg("variants") = py::none(), py::arg("budget") = 60,
        py::arg("most_samples") = 0, kTradeText);
}

}  // namespace pvol::python
