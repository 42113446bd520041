// .pvol files through the C API, from memory and from disk.
#include "pvol/pvol_file.h"

#include <gtest/gtest.h>

#include "capi/capi_fields.h"
#include "pvol/bounds/pyramid.h"
#include "pvol/formats/pvol_file.h"
#include "pvol/shell/fit_shell.h"
#include "pvol/shell/support.h"
#include "support/messages.h"
#include "support/temporary_folder.h"

namespace pvol::test {
namespace files_test {

class CapiFiles : public testing::Test {
 protected:
  TemporaryFolder folder_;
  Smoke smoke_;

  /// The smoke in a file, whole or without its density.
  std::filesystem::path write(bool with_density, bool with_shell) {
    formats::PvolFile file;
    file.metadata.index_to_world = placement();
    file.metadata.source.file = "smoke.vdb";
    file.metadata.written_by = "a test";
    VoxelGrid grid =
        make_grid({.values = smoke_.values.data(), .size = Vec3i(smoke_.n)}, placement());
    file.pyramid = build_pyramid(grid);
    if (with_shell) file.shell = fit_shell(make_support(grid, file.pyramid), {.perturbations = 2});
    if (with_density) file.density = std::move(grid);
    const std::filesystem::path path = folder_.file("smoke.pvol");
    formats::write_pvol(path, file);
    return path;
  }
  static void expect_same(const api::Volume& a, const api::Volume& b) {
    ASSERT_EQ(a.box(), b.box());
    Rng rng(1, 2, 3);
    int collisions = 0;
    for (std::uint64_t i = 0; i < 300; ++i) {
      const pvol_ray ray = random_ray(rng, 40);
      api::Random x(1, 2, i), y(1, 2, i);
      const auto t = a.flight(ray, x);
      ASSERT_EQ(t, b.flight(ray, y));
      collisions += t.has_value();
    }
    EXPECT_GT(collisions, 50);
  }
};

TEST_F(CapiFiles, AreTheVolumesTheyWereMadeOf) {
  const auto path = write(true, true);
  const api::Volume fresh = make_smoke(smoke_, 3);
  api::Volume from_file, from_memory;
  ASSERT_EQ(pvol_read_file(from_file.get(), path.c_str()), PVOL_OK);
  {
    const std::string bytes = read_bytes(path);
    ASSERT_EQ(pvol_read_bytes(from_memory.get(), bytes.data(), bytes.size()), PVOL_OK);
  }
  expect_same(from_file.set_extinction(3).commit(), fresh);
  expect_same(from_memory.set_extinction(3).set_shell(true).commit(), fresh);

  // The shell is the file's: two spans at most of two perturbations, and less than the box.
  Rng rng(3, 3, 3);
  double in_shell = 0, in_box = 0;
  for (int i = 0; i < 200; ++i) {
    const pvol_ray ray = random_ray(rng, smoke_.n);
    pvol_span spans[8], box;
    const int count = pvol_shell_spans(from_memory.get(), &ray, spans, 8);
    for (int k = 0; k < count; ++k) in_shell += spans[k].t1 - spans[k].t0;
    if (pvol_shell_spans(from_file.get(), &ray, &box, 1) == 1) in_box += box.t1 - box.t0;
  }
  EXPECT_LT(in_shell, in_box);
  EXPECT_GT(in_shell, 0);

  // Another place, another interpolation, and updates, as of other samples.
  from_file.set_extinction(3).set_transform(PVOL_DENSITY, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0});
  from_file.commit();
  EXPECT_EQ(from_file.density({20, 20, 20}), fresh.density(place_of(20, 20, 20)));
  ASSERT_EQ(pvol_read_file(from_file.get(), path.c_str()), PVOL_OK);
  from_file.set_interpolation(PVOL_TRICUBIC).commit();
  EXPECT_GT(from_file.density(place_of(20, 20, 20)), 0);
}

TEST_F(CapiFiles, ThatAreDamagedAreRefused) {
  const auto path = write(true, false);
  const std::string bytes = read_bytes(path);
  api::Volume v = make_smoke(smoke_);
  const std::size_t ends[] = {0, 1, 10, 63, bytes.size() / 2, bytes.size() - 1};
  for (const std::size_t end : ends) {
    EXPECT_EQ(pvol_read_bytes(v.get(), bytes.data(), end), PVOL_INVALID) << end;
    EXPECT_TRUE(says(pvol_message(v.get()), "capi.bytes_memory_damaged")) << pvol_message(v.get());
  }
  for (std::size_t at = 0; at < bytes.size(); at += 1 + bytes.size() / 300) {
    std::string flipped = bytes;
    flipped[at] = char(flipped[at] ^ 0x10);
    EXPECT_NE(pvol_read_bytes(v.get(), flipped.data(), flipped.size()), PVOL_OK) << at;
  }
  EXPECT_EQ(pvol_read_bytes(v.get(), nullptr, 100), PVOL_INVALID);
  EXPECT_EQ(pvol_read_file(v.get(), nullptr), PVOL_INVALID);
  EXPECT_EQ(pvol_read_file(v.get(), folder_.file("none.pvol").c_str()), PVOL_INVALID);
  EXPECT_NE(std::string(pvol_message(v.get())).find("none.pvol"), std::string::npos);
  v.commit();
  EXPECT_GT(v.density(place_of(20, 20, 20)), 0) << "the volume is as it was";
}

TEST_F(CapiFiles, WithoutADensityAreRefused) {
  const auto path = write(false, false);
  api::Volume v;
  EXPECT_EQ(pvol_read_file(v.get(), path.c_str()), PVOL_INVALID);
  EXPECT_NE(std::string(pvol_message(v.get())).find("smoke.vdb"), std::string::npos)
      << pvol_message(v.get());
}

}  // namespace files_test
}  // namespace pvol::test
