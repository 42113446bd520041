// Scenes that are refused: every message with its place.
#include <gtest/gtest.h>

#include "pvol/formats/scene_file.h"
#include "support/scene_text.h"

namespace pvol::formats {
namespace scene_errors_test {

TEST_F(SceneText, BadTextIsRefusedWithItsPlace) {
  const std::pair<const char*, const char*> cases[] = {
      // text after the two lines of kCloud, and the whole message
      {"[camera\n", "s.toml:3:8: not valid TOML: "},
      {"x = = 1", "s.toml:3:5: not valid TOML: "},
      {"[volume]\n", "s.toml:3:1: not valid TOML: "},
      {"[light]\n",
       "s.toml:3:2: unknown section or key \"light\"; expected one of volume, world, camera, "
       "medium, "
       "environment, sun, point, spot, area, plane, ball, solid, mesh or render"},
      {"[world]\nup = \"x\"\n", "s.toml:4:6: world.up is \"x\"; expected \"y\" or \"z\""},
      {"[[mesh]]\nalbedo = 0.5\n",
       "s.toml:3:1: [mesh[1]] has no file; expected the name of a file"},
      {"[[plane]]\nlook = \"glass\"\n",
       "s.toml:4:8: plane[1].look is \"glass\"; expected \"surface\", \"shadow-catcher\" or "
       "\"holdout\""},
      {"[[ball]]\nradius = 0\n", "s.toml:4:10: ball[1].radius is 0; expected a number above 0"},
      {"[[mesh]]\nfile = \"a.obj\"\nscale = [1, 0, 1]\n",
       "s.toml:5:9: mesh[1].scale is an array of 3; expected an invertible placement"},
      {"[[plane]]\ncentre = [0, 0, 0]\n",
       "unknown key \"centre\" in [plane[1]]; expected one of point, normal, albedo or look"},
      {"[rendr]\n",
       "environment, sun, point, spot, area, plane, ball, solid, mesh or render; did you mean "
       "\"render\"?"},
      {"[camera]\nposition = [0, 0, 0]\n", "s.toml:3:1: [camera] has no target; add it"},
      {"[camera]\n  fovv = 3\n",
       "s.toml:4:3: unknown key \"fovv\" in [camera]; expected one of position, target, up, "
       "matrix, projection, fov, focal_length, sensor, sensor_fit, shift, ortho_scale, f_stop, "
       "focus_distance, metres, azimuth, elevation, zoom, shutter or fps; did you mean \"fov\"?"},
      {"[camera]\nposition = [0, 0, 0]\ntarget = [0, 0, 1]\nfov = 180\n",
       "s.toml:6:7: camera.fov is 180; expected a number in (0, 180)"},
      {"[camera]\nposition = [0, 0, 0]\ntarget = [0, 0, 1]\nfov = \"wide\"\n",
       "s.toml:6:7: camera.fov is \"wide\"; expected a number in (0, 180)"},
      {"[camera]\nposition = [0, 0]\ntarget = [0, 0, 1]\n",
       "s.toml:4:12: camera.position is an array of 2; expected an array of 3 numbers"},
      {"[camera]\nposition = [0, \"a\", 0]\ntarget = [0, 0, 1]\n",
       "s.toml:4:16: camera.position[2] is \"a\"; expected a finite number"},
      {"[camera]\nposition = [0, 0, nan]\ntarget = [0, 0, 1]\n",
       "s.toml:4:19: camera.position[3] is nan; expected a finite number"},
      {"[camera]\nposition = [1, 1, 1]\ntarget = [1, 1, 1]\n",
       "s.toml:5:10: camera.target is an array of 3; expected a point other than position"},
      {"[camera]\nposition = [0, 0, 0]\ntarget = [0, -2, 0]\n",
       "s.toml:5:10: camera.target is an array of 3; expected up, by default [0, 1, 0], not along"},
      {"[camera]\nposition = [0, 0, 0]\ntarget = [0, 0, 2]\nup = [0, 0, -1]\n",
       "s.toml:6:6: camera.up is an array of 3; expected up"},
      {"[camera]\nposition = [0, 0, 0]\ntarget = [0, 0, 2]\nup = [0, 0, 0]\n",
       "s.toml:6:6: camera.up is an array of 3; expected a direction that is not zero"},
      {"[camera]\nmatrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1]\n",
       "s.toml:4:10: camera.matrix is an array of 16; expected a matrix of rotation, scale"},
      {"[camera]\nmatrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\nup = [0, 1, 0]\n",
       "s.toml:5:6: camera.up is an array of 3; expected either a matrix or position"},
      {"[camera]\nposition = [0, 0, 0]\ntarget = [0, 0, 1]\nzoom = 2\n",
       "s.toml:6:8: camera.zoom is 2; expected none for a camera with a position"},
      {"[camera]\nposition = [0, 0, 0]\ntarget = [0, 0, 1]\nprojection = \"latlong\"\n"
       "f_stop = 2\n",
       "s.toml:7:10: camera.f_stop is 2; expected none, since only perspective cameras"},
      {"[camera]\nshutter = [0.5, -0.5]\n",
       "s.toml:4:11: camera.shutter is an array of 2; expected an opening time before the closing "
       "time"},
      {"[camera]\nshutter = 0.5\n",
       "s.toml:4:11: camera.shutter is 0.5; expected an array of 2 numbers"},
      {"[camera]\nfps = 0\n", "s.toml:4:7: camera.fps is 0; expected a number in [0.001, 1e+06]"},
      {"[medium.motion]\nfeld = \"v\"\n",
       "s.toml:4:1: unknown key \"feld\" in [medium.motion]; expected one of field, file or scale; "
       "did you mean \"field\"?"},
      {"[medium.motion]\nscale = \"fast\"\n",
       "s.toml:4:9: medium.motion.scale is \"fast\"; expected a number in [-1e+06, 1e+06]"},
      {"[medium]\nalbedo = 1.01\n",
       "s.toml:4:10: medium.albedo is 1.01; expected a number in [0, 1]"},
      {"[medium]\nalbedo = [0.5, 0.5, -0.5]\n",
       "s.toml:4:21: medium.albedo[3] is -0.5; expected a number in [0, 1]"},
      {"[medium]\nextinction_color = [0.5, 0.5, 0.9]\n",
       "s.toml:4:20: medium.extinction_color is an array of 3; expected shares of which the "
       "largest is 1; scale with extinction instead"},
      {"[medium.density]\nramp = [[0, 0], [1, 2], [0.5, 1]]\n",
       "s.toml:4:8: medium.density.ramp is an array of 3; expected points with ascending first "
       "numbers"},
      {"[medium.density]\nclamp = [1, 0]\n",
       "s.toml:4:9: medium.density.clamp is an array of 2; expected the smallest value, then the "
       "largest"},
      {"[medium.density]\npower = 0\n",
       "s.toml:4:9: medium.density.power is 0; expected a number in (0, 64]"},
      {"[medium.density]\nfactor = 2\n",
       "s.toml:4:1: unknown key \"factor\" in [medium.density]; expected one of scale, offset, "
       "clamp, power, ramp or smooth"},
      {"[medium.fire]\nintensity = -1\n",
       "s.toml:4:13: medium.fire.intensity is -1; expected a number in [0, 1e+30]"},
      {"[medium.fire]\nkelvin = 0\n", "s.toml:4:10: medium.fire.kelvin is 0; expected a number in"},
      {"[medium.fire]\nkelvin = 1\ncolors = [[0, 1, 1, 1]]\n",
       "s.toml:5:10: medium.fire.colors is an array of 1; expected either the colour of a black "
       "body or a ramp of colours"},
      {"[medium.fire]\nkelvin_of_intensity = 1500\n",
       "s.toml:4:23: medium.fire.kelvin_of_intensity is 1500; expected kelvin"},
      {"[medium.fire]\ncolors = [[0, 1, 1]]\n", "s.toml:4:11: medium.fire.colors[1] is"},
      {"[medium.albedo_field]\ncolors = [[0, 1, 1, 1.5]]\n",
       "s.toml:4:10: medium.albedo_field.colors is an array of 1; expected colours in [0, 1], "
       "which multiply the albedo"},
      {"[medium.albedo_field]\nfield = \"Cd\"\n",
       "s.toml:4:1: unknown key \"field\" in [medium.albedo_field]; expected one of grid, scale, "
       "offset, clamp, power, ramp, smooth or colors"},
      {"[medium.albedo]\ngrid = \"Cd\"\n",
       "medium.albedo is a table; expected a number or three; set a grid of albedos in "
       "[medium.albedo_field]"},
      {"[medium]\nalbedo = [0.5, 0.5]\n",
       "medium.albedo is an array of 2; expected a number in [0, 1], or an array of 3 of them"},
      {"[medium]\ng = 1\n", "s.toml:4:5: medium.g is 1; expected a number in [-0.9999, 0.9999]"},
      {"[medium]\ng = 0\nrayleigh = true\n",
       "s.toml:5:1: unknown key \"rayleigh\" in [medium]; expected one of extinction, "
       "extinction_color, albedo, g,"},
      {"[medium]\nrayleigh = false\n",
       "s.toml:4:12: medium.rayleigh is false; expected true, or another phase function"},
      {"[medium]\nrayleigh = 1\n", "s.toml:4:12: medium.rayleigh is 1; expected true or false"},
      {"[medium]\ndraine_g = 1\n",
       "s.toml:4:12: medium.draine_g is 1; expected a number in [-0.9999, 0.9999]"},
      {"[medium]\ndraine_g = 0.5\ndraine_alpha = -1\n",
       "s.toml:5:16: medium.draine_alpha is -1; expected a number in [0, 10000]"},
      {"[medium]\ndroplet_diameter = 0\n",
       "s.toml:4:20: medium.droplet_diameter is 0; expected a number in (0, 50]"},
      {"[medium]\nphase_table = 3\n",
       "s.toml:4:15: medium.phase_table is 3; expected an array of points [angle, value], or the "
       "name of a file of them"},
      {"[medium]\nphase_table = [0, 1]\n",
       "s.toml:4:15: medium.phase_table is an array of 2; expected at least two points [angle, "
       "value]"},
      {"[medium]\nphase_table = [[0, 1], [180]]\n",
       "s.toml:4:24: medium.phase_table[2] is an array of 1; expected an array of 2 numbers"},
      {"[medium]\nphase_table = [[0, 1], [120, 1]]\n",
       "expected angles from 0 to 180 degrees, both included"},
      {"[medium]\nphase_table = [[0, 1], [90, -1], [180, 1]]\n",
       "expected values that are finite and at least 0"},
      {"[medium]\nphase_table = \"absent.txt\"\n", "absent.txt\", which cannot be read; check"},
      {"[medium]\nextinction = -1\n",
       "s.toml:4:14: medium.extinction is -1; expected a number of at least 0"},
      {"[medium]\nextinction = inf\n",
       "s.toml:4:14: medium.extinction is inf; expected a number of at least 0"},
      {"[medium]\nscale = 0\n", "s.toml:4:9: medium.scale is 0; expected an invertible placement"},
      {"[medium]\nrotate = [0, 0, 0, 30]\n",
       "s.toml:4:10: medium.rotate is an array of 4; expected an axis that is not zero"},
      {"[medium]\nrotate = [[0, 0, 1, 30], [0, 1]]\n",
       "s.toml:4:26: medium.rotate[2] is an array of 2; expected an array of 4 numbers"},
      {"[medium]\nmatrix = [1, 2]\n", "expected an array of 12 or 16 numbers"},
      {"[medium]\nmatrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1]\n",
       "s.toml:4:10: medium.matrix is an array of 16; expected a last row of 0, 0, 0, 1, with the"},
      {"[medium]\nmatrix = [1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0]\n",
       "s.toml:4:10: medium.matrix is an array of 12; expected an invertible placement"},
      {"[medium]\nmatrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]\nscale = 2\n",
       "s.toml:5:9: medium.scale is 2; expected either matrix, or scale, rotate and translate"},
      {"[[volume.instance]]\nscale = 2\n[[volume.instance]]\nscale = 0\n",
       "s.toml:6:9: volume.instance[2].scale is 0; expected an invertible placement"},
      {"[[volume.instance]]\nmatrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]\nscale = 2\n",
       "s.toml:5:9: volume.instance[1].scale is 2; expected either matrix, or scale, rotate and"},
      {"[[volume.instance]]\nextinction = 2\n",
       "s.toml:4:1: unknown key \"extinction\" in [volume.instance[1]]; expected one of scale, "
       "rotate, translate, matrix or to"},
      {"[[volume.instance]]\nto = { speed = 3 }\n",
       "s.toml:4:8: unknown key \"speed\" in [volume.instance[1].to]; expected one of scale, "
       "rotate, "
       "translate or matrix"},
      {"[volume.to]\nscale = 0\n",
       "s.toml:4:9: volume.to.scale is 0; expected an invertible placement, with no scale of 0"},
      {"[volume.to]\nscale = [1, -1, 1]\n",
       "s.toml:4:9: volume.to.scale is an array of 3; expected a placement that mirrors if and "
       "only if the first one does"},
      {"[volume.to]\nscale = [-1, -1, 1]\n",
       "s.toml:4:9: volume.to.scale is an array of 3; expected scales with the signs of the first "
       "ones, so that none passes 0"},
      {"[volume.to]\nrotate = [1, 0, 0, 180]\n[medium]\nrotate = [0, 1, 0, 0]\n",
       "s.toml:4:10: volume.to.rotate is an array of 4; expected a rotation of less than half a "
       "turn from the first placement, or degrees about the same axes, which determine the way"},
      {"[volume.to]\ntranslate = [1, 0, 0]\n[medium]\nmatrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, "
       "0]\n",
       "s.toml:4:13: volume.to.translate is an array of 3; expected a matrix, since the first "
       "placement has one"},
      {"[environment]\ntype = \"imge\"\n",
       "s.toml:4:8: environment.type is \"imge\"; expected \"constant\", \"gradient\", "
       "\"image\" or \"clear\"; "
       "did you mean \"image\"?"},
      {"[environment]\ntype = \"image\"\n",
       "s.toml:3:1: [environment] has no file; expected the name of a file"},
      {"[environment]\ntype = \"constant\"\nzenith = 1\n",
       "s.toml:5:1: unknown key \"zenith\" in [environment]; expected one of type or radiance"},
      {"[environment]\nradiance = -1\n",
       "s.toml:4:12: environment.radiance is -1; expected a number in [0, 1e+30]"},
      {"[[sun]]\n[[sun]]\nangle = 180.0\n",
       "s.toml:5:9: sun[2].angle is 180.0; expected a number in [0, 180)"},
      {"[[sun]]\nirradiance = [1, 1, 1e39]\n",
       "s.toml:4:21: sun[1].irradiance[3] is 1e+39; expected a number in [0, 1e+30]"},
      {"[sun]\ndirection = [0, 0, 0]\n",
       "s.toml:4:13: sun.direction is an array of 3; expected a direction that is not zero"},
      {"[render]\nsun = 5\n", "s.toml:4:1: unknown key \"sun\" in [render]"},
      {"[render]\nsize = [0, 10]\n",
       "s.toml:4:9: render.size[1] is 0; expected a whole number in 1..1048576"},
      {"[render]\nsize = [10.5, 10]\n", "s.toml:4:9: render.size[1] is 10.5; expected a whole"},
      {"[render]\nsize = [100, 50]\ncrop = [90, 0, 11, 50]\n",
       "s.toml:5:8: render.crop is an array of 4; expected [x, y, width, height] inside the image "
       "of 100 x 50 pixels"},
      {"[render]\nspp = 0\n", "s.toml:4:7: render.spp is 0; expected a whole number in 1..429496"},
      {"[render]\nseed = -1\n",
       "s.toml:4:8: render.seed is -1; expected a whole number in 0..9223"},
      {"[render]\ntracker = \"deltta\"\n",
       "s.toml:4:11: render.tracker is \"deltta\"; expected \"delta-global\", \"delta\", "
       "\"decomposition\", \"weighted-delta\", \"weighted-decomposition\" or \"regular\"; "
       "did you mean \"delta\"?"},
      {"[render]\ndepth = 17\n",
       "s.toml:4:9: render.depth is 17; expected a whole number in 0..16 or \"auto\""},
      {"[render]\ndepth = \"deep\"\n",
       "s.toml:4:9: render.depth is \"deep\"; expected a whole number in 0..16 or \"auto\""},
      {"[render]\nmax_bounces = 1979-05-27\n",
       "s.toml:4:15: render.max_bounces is a date or time; expected a whole number in"},
      {"[render]\nbackground = \"off\"\n",
       "s.toml:4:14: render.background is \"off\"; expected true or false"},
  };
  for (const auto& [text, message] : cases) {
    EXPECT_NE(error(kCloud + text).find(message), std::string::npos)
        << text << "gave\n  " << error(kCloud + text) << "\nexpected\n  " << message;
  }
}

TEST_F(SceneText, BadPhaseFilesAreRefusedWithTheirLines) {
  const std::pair<const char*, const char*> cases[] = {
      {"# nothing\n", "p.txt: has no points; expected lines of an angle in degrees and a value"},
      {"0 1\n\n9O 1\n180 1\n", "p.txt:3: found \"9O 1\"; expected an angle in degrees and a value"},
      {"0 1\n90\n180 1\n", "p.txt:2: found \"90\"; expected an angle in degrees and a value"},
      {"0 1 2\n180 1\n", "p.txt:1: found \"0 1 2\"; expected an angle"},
      {"0,,1\n", "p.txt:1: found \"0,,1\"; expected an angle"},
      {"0 nan\n", "p.txt:1: found \"0 nan\"; expected an angle"},
      {"0 1\n181 1\n", "p.txt:2: the angle is 181; expected degrees in [0, 180]"},
      {"0 1\n180 -2\n", "p.txt:2: the value is -2; expected a number of at least 0"},
      {"0 1\n9 2\n9 3\n180 1\n",
       "p.txt:3: the angle is 9 after 9; expected ascending angles: sort"},
      {"0 1\n90 1\n",
       "p.txt: medium.phase_table is an array of 2; expected angles from 0 to 180 degrees"},
      {"0 0\n180 0\n",
       "p.txt: medium.phase_table is an array of 2; expected values that are not all"},
      {"0 1\n", "p.txt: medium.phase_table is an array of 1; expected at least two points"},
  };
  for (const auto& [text, message] : cases) {
    std::ofstream(folder_ / "p.txt", std::ios::binary) << text;
    const std::string found = error(kCloud + "[medium]\nphase_table = \"p.txt\"\n");
    EXPECT_EQ(found.substr(0, std::string(message).size()), message) << text;
  }
  EXPECT_NE(
      error(kCloud + "[medium]\nphase_table = \".\"\n").find("cannot be read; check the name"),
      std::string::npos);
  std::ofstream(folder_ / "p.txt", std::ios::binary) << std::string((4 << 20) + 1, '#');
  EXPECT_NE(error(kCloud + "[medium]\nphase_table = \"p.txt\"\n").find("more than 4 MiB"),
            std::string::npos);
}

TEST_F(SceneText, BadFrameworkIsRefused) {
  EXPECT_EQ(error(""), "s.toml: there is no [volume]; add it");
  EXPECT_EQ(error("[volume]\n"), "s.toml:1:1: [volume] has no file; expected the name of a file");
  EXPECT_EQ(error("volume = 3\n"),
            "s.toml:1:10: volume is 3; expected a table [volume] or tables [[volume]]");
  EXPECT_EQ(error(kCloud + "[render]\n[[render.sun]]\n"),
            "s.toml:4:10: unknown key \"sun\" in [render]; expected one of size, crop, spp, "
            "noise, time, first_sample, seed, tracker, transmittance, micro_bounds, interpolation, "
            "shells, guide, kernel, line_emission, emission_points, depth, max_bounces, "
            "background, filter, filter_width, aov, deep_bins, deep_error, "
            "density, density_tolerance, majorant_scale, homogenise or preview");
  EXPECT_EQ(error("sun = [1]\n" + kCloud), "s.toml:1:8: sun[1] is 1; expected a table");
  EXPECT_NE(error("[recipe]\n").find("s.toml: found a recipe"), std::string::npos);
  EXPECT_NE(error("volume.fil = 3\n").find("s.toml:1:8: unknown key \"fil\" in [volume]"),
            std::string::npos);
  EXPECT_NE(error(std::string("a = \"\xff\"")).find("s.toml:1:"), std::string::npos);
  EXPECT_THROW((void)read_scene(folder_), Error);
  EXPECT_THROW((void)read_scene(folder_ / "absent.toml"), Error);
}

TEST_F(SceneText, BadSetsAreRefusedWithTheirText) {
  const std::pair<const char*, const char*> cases[] = {
      {"medium.g=2", "--set medium.g=2: medium.g is 2; expected a number in [-0.9999, 0.9999]"},
      {"medium.g", "--set medium.g: expected SECTION.KEY=VALUE, e.g. medium.g=0.5"},
      {"medium.g=", "--set medium.g=: expected SECTION.KEY=VALUE"},
      {"=3", "--set =3: expected SECTION.KEY=VALUE"},
      {"medium..g=3", "--set medium..g=3: expected SECTION.KEY=VALUE"},
      {"", "--set : expected SECTION.KEY=VALUE"},
      {"medium.G=0", "--set medium.G=0: unknown key \"G\" in [medium]; expected one of"},
      {"medium.g=0.5.5", "--set medium.g=0.5.5: medium.g is \"0.5.5\"; expected a number in"},
      {"medium.albedo=[1, 2", "--set medium.albedo=[1, 2: the value is not valid TOML: "},
      {"medium.albedo=[1, 2, 1]",
       "--set medium.albedo=[1, 2, 1]: medium.albedo[2] is 2; expected a number in [0, 1]"},
      {
          "volume.file.x=1",
          "--set volume.file.x=1: volume.file is \"cloud.pvol\" and has no keys",
      },
      {"camera.target=[0, 0, 0]",
       "--set camera.target=[0, 0, 0]: [camera] has no position; add it"},
      {"volume[2].grid=smoke",
       "--set volume[2].grid=smoke: volume is a table, not a list of tables"},
      {"sun[2].angle=1", "--set sun[2].angle=1: there is no sun[2]; expected a number up to 1"},
      {"sun[0].angle=1",
       "--set sun[0].angle=1: expected a number from 1 in the brackets of sun[0]"},
      {"sun[1.angle=1",
       "--set sun[1.angle=1: expected a number from 1 in brackets at the end of sun[1"},
      {"camera.fov=true", "--set camera.fov=true: camera.fov is true; expected a number in"},
      {"camera.fov.x=1", "--set camera.fov.x=1: camera.fov is a table; expected a number in"},
      {"g=0.5", "--set g=0.5: unknown section or key \"g\"; expected one of volume, world, camera"},
  };
  for (const auto& [set, message] : cases) {
    std::string found = error("[volume]\nfile = \"cloud.pvol\"\n", {set});
    if (const auto at = found.find((folder_ / "").string()); at != std::string::npos) {
      found.erase(at, (folder_ / "").string().size());
    }
    EXPECT_EQ(found.substr(0, std::string(message).size()), message);
  }
}

/// "a.a.a" of so many keys.
std::string path(std::size_t keys) {
  std::string text = "a";
  for (std::size_t i = 1; i < keys; ++i) text += ".a";
  return text;
}

TEST_F(SceneText, TablesThatNestTooDeepAreRefused) {
  // A key of 100000 levels overflowed the stack.
  const std::string many = path(100000), some = path(150);
  const std::pair<std::string, const char*> cases[] = {
      {"[" + many + "]\n", "s.toml:3: tables and arrays nest more than 256 levels"},
      {"[[" + many + "]]\n", "s.toml:3: "},
      {"\n" + many + " = 1\n", "s.toml:4: "},
      {"\"a\"." + many + " = 1\n", "s.toml:3: "},
      {"[" + some + "]\n" + some + " = 1\n", "s.toml:4: "},
      {"x = [{" + some + " = {" + some + " = 1}}]\n", "s.toml:3: "},
      {"x = {y = \"\"\"\"\\\"\n'\"\"\", " + many + " = 1}\n", "s.toml:4: "},
  };
  for (const auto& [text, message] : cases) {
    const std::string found = error(kCloud + text);
    EXPECT_EQ(found.find(message), 0u) << found.substr(0, 200);
    EXPECT_NE(found.find("levels deep"), std::string::npos) << found.substr(0, 200);
  }
  const std::string set = error(kCloud, {many + "=1"}) + error(kCloud, {"a={" + many + "=1}"});
  EXPECT_NE(set.find("levels deep"), std::string::npos);
}

TEST_F(SceneText, NamesOfKeysAreLimited) {
  const std::string key(5000, 'k');
  EXPECT_NE(error(kCloud + key + " = 1\n").find("a key of 5007 bytes"), std::string::npos);
}

TEST_F(SceneText, DotsThatAreNoLevelsAreAllowed) {
  std::string text = "# " + path(999) + "\n[camera]\nposition = [0, 0, 0]\ntarget = [";
  for (int i = 0; i < 999; ++i) text += "1.0, ";
  const std::string refusal = error(kCloud + text + "]\n");
  EXPECT_NE(refusal.find("camera.target is an array of 999"), std::string::npos) << refusal;
  std::string forgotten = "[camera]\ntarget = [0, 0, 0\n";
  for (int i = 0; i < 999; ++i) forgotten += "sun.angle = 0.5\n";
  EXPECT_EQ(error(kCloud + forgotten).find("s.toml:5:"), 0u) << error(kCloud + forgotten);
  EXPECT_NE(error(kCloud + "[" + path(200) + "]\n").find("unknown section"), std::string::npos);
  EXPECT_NE(error(kCloud + "x = \"" + path(999) + "\"\n").find("unknown"), std::string::npos);
}

}  // namespace scene_errors_test
}  // namespace pvol::formats
