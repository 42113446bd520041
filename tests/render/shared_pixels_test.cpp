// Pixels that copies share: what is edited in one of them, the others do not see.
#include "pvol/render/shared_pixels.h"

#include <gtest/gtest.h>

#include <limits>

#include "pvol/render/sky.h"
#include "support/error_of.h"

namespace pvol {
namespace shared_pixels_test {

TEST(SharedPixels, CopiesShareUntilOneIsEdited) {
  const SharedPixels a{Rgb(1.0f), Rgb(2.0f)};
  SharedPixels b = a;
  EXPECT_EQ(a.begin(), b.begin()) << "the same memory";
  b.edit()[1] = Rgb(5.0f);
  EXPECT_NE(a.begin(), b.begin());
  EXPECT_EQ(a[1], Rgb(2.0f));
  EXPECT_EQ(b[1], Rgb(5.0f));
  EXPECT_NE(a, b);
  b.edit()[1] = Rgb(2.0f);
  EXPECT_EQ(a, b) << "by value";
  EXPECT_EQ(SharedPixels(), SharedPixels(std::vector<Rgb>{}));
  EXPECT_TRUE(SharedPixels().empty());
}

TEST(SharedPixels, LargestIsThatOfAllChannelsAndOfNothingThatIsNoLight) {
  SharedPixels p{Rgb(1, 5, 0), Rgb(3, 2, 4)};
  EXPECT_EQ(p.largest(), Rgb(3, 5, 4));
  p.edit()[0] = Rgb(9, 0, 0);
  EXPECT_EQ(p.largest(), Rgb(9, 2, 4)) << "after an edit";
  for (const float bad :
       {-1e-30f, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    p.edit()[1] = Rgb(0, bad, 0);
    EXPECT_FALSE(p.largest()) << bad;
    EXPECT_FALSE(SharedPixels(std::vector<Rgb>(p.begin(), p.end())).largest()) << bad;
    EXPECT_THROW(validate(ImageSky{2, 1, p}), Error) << bad;
  }
  EXPECT_FALSE(SharedPixels().largest()) << "without pixels";
}

TEST(SharedPixels, SkiesAreRefusedThatTheirScaleMakesInfinite) {
  const ImageSky bright{2, 1, {Rgb(0.0f), Rgb(1e30f)}, Rgb(1e20f)};
  EXPECT_THROW(validate(bright), Error);
  EXPECT_NO_THROW(validate(ImageSky{2, 1, bright.pixels, Rgb(1e5f)}));
}

}  // namespace shared_pixels_test
}  // namespace pvol
