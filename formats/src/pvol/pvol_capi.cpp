// .pvol files for the C API.
#include <span>
#include <utility>

#include "pvol/error.h"
#include "pvol/formats/pvol_file.h"
#include "pvol/given_density.h"
#include "pvol/pvol_file.h"

namespace pvol::formats {
namespace {

[[nodiscard]] std::shared_ptr<const pvol::detail::BoundedDensity> given(PvolFile&& file,
                                                                        const std::string& name) {
  if (!file.density && !file.pyramid.empty()) {
    throw Error(name + ": the file has no density; it refers to " + file.metadata.source.file +
                "; fit it again with its density (pvol-fit --density fp32)");
  }
  auto d = std::make_shared<pvol::detail::BoundedDensity>();
  if (file.density) d->grid = *std::move(file.density);
  d->grid.index_to_world = file.metadata.index_to_world;
  d->pyramid = std::move(file.pyramid);
  if (file.shell) d->shell = std::make_shared<const Shell>(*std::move(file.shell));
  if (file.micro) d->micro_bounds = std::make_shared<const LeafMicroBounds>(*std::move(file.micro));
  return d;
}

}  // namespace
}  // namespace pvol::formats

extern "C" {

pvol_status pvol_read_bytes(pvol_volume* volume, const void* bytes, size_t size) {
  return pvol::detail::set_density(volume, [&] {
    if (bytes == nullptr) throw pvol::Error("the address of the bytes of a .pvol file is null");
    const std::string name = "the bytes in memory";
    const std::span all(static_cast<const std::byte*>(bytes), size);
    return pvol::formats::given(pvol::formats::read_pvol(all, name), name);
  });
}

pvol_status pvol_read_file(pvol_volume* volume, const char* path) {
  return pvol::detail::set_density(volume, [&] {
    if (path == nullptr) throw pvol::Error("the path of a .pvol file is null");
    return pvol::formats::given(pvol::formats::read_pvol(path), path);
  });
}

}  // extern "C"
