// Scenes that are refused: every message with its place.
#include <gtest/gtest.h>

#include "pvol/formats/scene_file.h"
#include "support/messages.h"
#include "support/scene_text.h"

namespace pvol::formats {
namespace scene_errors_test {

TEST_F(SceneText, BadTextIsRefusedWithItsPlace) {
  const std::pair<const char*, const char*> cases[] = {
      // text after the two lines of kCloud, and what is said
      {"[camera\n", "scene.bracket_missing"},
      {"x = = 1", "scene.value_missing"},
      {"[volume]\n", "scene.table_twice"},
      {"[[volume]]\nfile = \"b.pvol\"\n", "scene.section_becomes_list"},
      {"[light]\n", "scene.no_key_light"},
      {"[volume.medium]\ng = 0.5\n", "scene.medium_of_first"},
      {"[world]\nup = \"x\"\n", "scene.world_up_x"},
      {"[[mesh]]\nalbedo = 0.5\n", "scene.mesh_no"},
      {"[[plane]]\nlook = \"glass\"\n", "scene.plane_look_glass"},
      {"[[ball]]\nradius = 0\n", "scene.ball_radius_zero"},
      {"[[mesh]]\nfile = \"a.obj\"\nscale = [1, 0, 1]\n", "scene.mesh_scale_invertible_placement"},
      {"[[plane]]\ncentre = [0, 0, 0]\n", "scene.no_key_plane_centre"},
      {"[rendr]\n", "scene.no_key_rendr"},
      {"[camera]\nposition = [0, 0, 0]\n", "scene.camera_no_target"},
      {"[camera]\n  fovv = 3\n", "scene.no_key_camera_fovv"},
      {"[camera]\nposition = [0, 0, 0]\ntarget = [0, 0, 1]\nfov = 180\n", "scene.camera_fov_180"},
      {"[camera]\nposition = [0, 0, 0]\ntarget = [0, 0, 1]\nfov = \"wide\"\n",
       "scene.camera_fov_wide"},
      {"[camera]\nposition = [0, 0]\ntarget = [0, 0, 1]\n", "scene.camera_position_array_numbers"},
      {"[camera]\nposition = [0, \"a\", 0]\ntarget = [0, 0, 1]\n", "scene.camera_position_2"},
      {"[camera]\nposition = [0, 0, nan]\ntarget = [0, 0, 1]\n", "scene.camera_position_3_nan"},
      {"[camera]\nposition = [1, 1, 1]\ntarget = [1, 1, 1]\n",
       "scene.camera_target_point_position"},
      {"[camera]\nposition = [0, 0, 0]\ntarget = [0, -2, 0]\n", "scene.camera_target_up_default"},
      {"[camera]\nposition = [0, 0, 0]\ntarget = [0, 0, 2]\nup = [0, 0, -1]\n",
       "scene.camera_up_up_default"},
      {"[camera]\nposition = [0, 0, 0]\ntarget = [0, 0, 2]\nup = [0, 0, 0]\n",
       "scene.camera_up_direction_not"},
      {"[camera]\nmatrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1]\n",
       "scene.camera_matrix_matrix_rotation"},
      {"[camera]\nmatrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\nup = [0, 1, 0]\n",
       "scene.camera_up_either_matrix"},
      {"[camera]\nposition = [0, 0, 0]\ntarget = [0, 0, 1]\nzoom = 2\n", "scene.camera_zoom_2"},
      {"[camera]\nposition = [0, 0, 0]\ntarget = [0, 0, 1]\nprojection = \"latlong\"\n"
       "f_stop = 2\n",
       "scene.camera_f_stop_2"},
      {"[camera]\nshutter = [0.5, -0.5]\n", "scene.camera_shutter_opening_time"},
      {"[camera]\nshutter = 0.5\n", "scene.camera_shutter_0_5"},
      {"[camera]\nfps = 0\n", "scene.camera_fps_zero"},
      {"[medium.motion]\nfeld = \"v\"\n", "scene.no_key_motion_feld"},
      {"[medium.motion]\nscale = \"fast\"\n", "scene.motion_scale_fast"},
      {"[medium]\nalbedo = 1.01\n", "scene.albedo_1_01"},
      {"[medium]\nalbedo = [0.5, 0.5, -0.5]\n", "scene.albedo_3_negative"},
      {"[medium]\nextinction_color = [0.5, 0.5, 0.9]\n", "scene.extinction_color_shares_largest"},
      {"[medium.density]\nramp = [[0, 0], [1, 2], [0.5, 1]]\n",
       "scene.density_ramp_points_ascending"},
      {"[medium.density]\nclamp = [1, 0]\n", "scene.density_clamp_smallest_value"},
      {"[medium.density]\npower = 0\n", "scene.density_power_zero"},
      {"[medium.density]\nfactor = 2\n", "scene.no_key_density_factor"},
      {"[medium.fire]\nintensity = -1\n", "scene.fire_intensity_negative"},
      {"[medium.fire]\nkelvin = 0\n", "scene.fire_kelvin_zero"},
      {"[medium.fire]\nkelvin = 1\ncolors = [[0, 1, 1, 1]]\n", "scene.fire_colors_either_colour"},
      {"[medium.fire]\nkelvin_of_intensity = 1500\n", "scene.fire_kelvin_of_intensity_1500"},
      {"[medium.fire]\ncolors = [[0, 1, 1]]\n", "scene.fire_colors_1_array_numbers"},
      {"[medium.albedo_field]\ncolors = [[0, 1, 1, 1.5]]\n",
       "scene.albedo_field_colors_colours_multiply"},
      {"[medium.albedo_field]\nfield = \"Cd\"\n", "scene.no_key_albedo_field_field"},
      {"[medium.albedo]\ngrid = \"Cd\"\n", "scene.albedo_number_three"},
      {"[medium]\nalbedo = [0.5, 0.5]\n", "scene.albedo_number_array"},
      {"[medium]\ng = 1\n", "scene.g_1"},
      {"[medium]\ng = 0\nrayleigh = true\n", "scene.two_phase_functions"},
      {"[medium]\ng_backward = -0.2\n", "scene.g_backward_alone"},
      {"[medium]\nphase = \"mie\"\n", "scene.no_key_medium_phase"},
      {"[medium]\nrayleigh = false\n", "scene.rayleigh_false"},
      {"[medium]\nrayleigh = 1\n", "scene.rayleigh_1"},
      {"[medium]\ndraine_g = 1\n", "scene.draine_g_1"},
      {"[medium]\ndraine_g = 0.5\ndraine_alpha = -1\n", "scene.draine_alpha_negative"},
      {"[medium]\ndroplet_diameter = 0\n", "scene.droplet_diameter_zero"},
      {"[medium]\nphase_table = 3\n", "scene.phase_table_3"},
      {"[medium]\nphase_table = [0, 1]\n", "scene.phase_table_least_two_points"},
      {"[medium]\nphase_table = [[0, 1], [180]]\n", "scene.phase_table_2_array_numbers"},
      {"[medium]\nphase_table = [[0, 1], [120, 1]]\n", "scene.phase_table_angles_degrees_both"},
      {"[medium]\nphase_table = [[0, 1], [90, -1], [180, 1]]\n", "scene.phase_table_values_finite"},
      {"[medium]\nphase_table = \"absent.txt\"\n", "scene.medium_phase_table_names_absent"},
      {"[medium]\nextinction = -1\n", "scene.extinction_negative"},
      {"[medium]\nextinction = inf\n", "scene.extinction_inf"},
      {"[medium]\nscale = 0\n", "scene.scale_zero"},
      {"[medium]\nrotate = [0, 0, 0, 30]\n", "scene.rotate_axis_not"},
      {"[medium]\nrotate = [[0, 0, 1, 30], [0, 1]]\n", "scene.rotate_2_array_numbers"},
      {"[medium]\nmatrix = [1, 2]\n", "scene.matrix_array_numbers"},
      {"[medium]\nmatrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1]\n",
       "scene.matrix_last_row"},
      {"[medium]\nmatrix = [1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0]\n",
       "scene.matrix_invertible_placement"},
      {"[medium]\nmatrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]\nscale = 2\n", "scene.scale_2"},
      {"[[volume.instance]]\nscale = 2\n[[volume.instance]]\nscale = 0\n",
       "scene.volume_instance_scale_zero"},
      {"[[volume.instance]]\nmatrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]\nscale = 2\n",
       "scene.volume_instance_scale_2"},
      {"[[volume.instance]]\nextinction = 2\n", "scene.no_key_instance_extinction"},
      {"[[volume.instance]]\nto = { speed = 3 }\n", "scene.no_key_to_speed"},
      {"[volume.to]\nscale = 0\n", "scene.volume_to_scale_zero"},
      {"[volume.to]\nscale = [1, -1, 1]\n", "scene.volume_to_scale_placement_mirrors"},
      {"[volume.to]\nscale = [-1, -1, 1]\n", "scene.volume_to_scale_scales_signs"},
      {"[volume.to]\nrotate = [1, 0, 0, 180]\n[medium]\nrotate = [0, 1, 0, 0]\n",
       "scene.volume_to_rotate_rotation_less"},
      {"[volume.to]\ntranslate = [1, 0, 0]\n[medium]\nmatrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, "
       "0]\n",
       "scene.volume_to_translate_matrix_since"},
      {"[camera.to]\nposition = [1, 2, 3]\n", "scene.camera_to_without_position"},
      {"[camera]\nposition = [0, 0, 5]\ntarget = [0, 0, 0]\n[camera.to]\nfov = 40\n",
       "scene.no_key_camera_to_fov"},
      {"[camera]\nposition = [0, 0, 5]\ntarget = [0, 0, 0]\nto = { target = [0, 0, 9] }\n",
       "scene.camera_to_half_turn"},
      {"[camera]\nposition = [0, 0, 5]\ntarget = [0, 0, 0]\n[camera.to]\nup = [0, 0, 1]\n",
       "scene.camera_to_along_up"},
      {"[camera]\nposition = [0, 0, 5]\ntarget = [0, 0, 0]\n[camera.to]\nup = [1, 0, 0]\n"
       "matrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n",
       "scene.camera_to_matrix_and_up"},
      {"[[ball]]\nto = { radius = 2 }\n", "scene.no_key_ball_to_radius"},
      {"[[plane]]\nto = { point = [0, 1, 0] }\n", "scene.no_key_plane_to"},
      {"[[mesh]]\nfile = \"a.obj\"\nto = { scale = [1, 1, -1] }\n", "scene.mesh_to_scale_mirrors"},
      {"[environment]\ntype = \"imge\"\n", "scene.environment_type_imge"},
      {"[environment]\ntype = \"image\"\n", "scene.environment_no"},
      {"[environment]\ntype = \"constant\"\nzenith = 1\n", "scene.no_key_environment_zenith"},
      {"[environment]\nradiance = -1\n", "scene.environment_radiance_negative"},
      {"[[sun]]\n[[sun]]\nangle = 180.0\n", "scene.sun_angle_180"},
      {"[[sun]]\nirradiance = [1, 1, 1e39]\n", "scene.sun_irradiance_3_1e_39"},
      {"[sun]\ndirection = [0, 0, 0]\n", "scene.sun_direction_direction_not"},
      {"[render]\nsun = 5\n", "scene.no_key_render_sun"},
      {"[render]\nsize = [0, 10]\n", "scene.size_1_0"},
      {"[render]\nsize = [10.5, 10]\n", "scene.size_1_10_5"},
      {"[render]\nsize = [100, 50]\ncrop = [90, 0, 11, 50]\n", "scene.crop_x_y"},
      {"[render]\nspp = 0\n", "scene.spp_zero"},
      {"[render]\nseed = -1\n", "scene.seed_negative"},
      {"[render]\ntracker = \"deltta\"\n", "scene.tracker_deltta"},
      {"[render]\ndepth = 24\n", "scene.depth_24"},
      {"[render]\ndepth = \"deep\"\n", "scene.depth_deep"},
      {"[render]\nmax_bounces = 1979-05-27\n", "scene.max_bounces_whole_number"},
      {"[render]\nbackground = \"off\"\n", "scene.background_off"},
  };
  for (const auto& [text, key] : cases) {
    EXPECT_TRUE(says(error(kCloud + text), key));
  }
}

TEST_F(SceneText, BadPhaseFilesAreRefusedWithTheirLines) {
  const std::pair<const char*, const char*> cases[] = {
      {"# nothing\n", "scene.no_points"},
      {"0 1\n\n9O 1\n180 1\n", "scene.phase_line_misspelt"},
      {"0 1\n90\n180 1\n", "scene.phase_line_of_one"},
      {"0 1 2\n180 1\n", "scene.phase_line_of_three"},
      {"0,,1\n", "scene.phase_line_of_commas"},
      {"0 nan\n", "scene.phase_line_of_nan"},
      {"0 1\n181 1\n", "scene.angle_expected_degrees"},
      {"0 1\n180 -2\n", "scene.value_minus"},
      {"0 1\n9 2\n9 3\n180 1\n", "scene.angle_after"},
      {"0 1\n90 1\n", "scene.phase_table_angles_degrees"},
      {"0 0\n180 0\n", "scene.phase_table_values_not"},
      {"0 1\n", "scene.phase_table_least_two"},
  };
  for (const auto& [text, key] : cases) {
    std::ofstream(folder_ / "p.txt", std::ios::binary) << text;
    EXPECT_TRUE(says(error(kCloud + "[medium]\nphase_table = \"p.txt\"\n"), key)) << text;
  }
  EXPECT_TRUE(
      says(error(kCloud + "[medium]\nphase_table = \".\"\n"), "scene.medium_phase_table_names"));
  std::ofstream(folder_ / "p.txt", std::ios::binary) << std::string((4 << 20) + 1, '#');
  EXPECT_TRUE(says(error(kCloud + "[medium]\nphase_table = \"p.txt\"\n"),
                   "scene.medium_phase_table_names_p"));
}

TEST_F(SceneText, BadFrameworkIsRefused) {
  EXPECT_TRUE(says(error(""), "scene.no_volume"));
  EXPECT_TRUE(says(error("[volume]\n"), "scene.volume_no"));
  EXPECT_TRUE(says(error("volume = 3\n"), "scene.volume_3"));
  EXPECT_TRUE(says(error(kCloud + "[render]\n[[render.sun]]\n"), "scene.no_key_render_sun_table"));
  EXPECT_TRUE(says(error("sun = [1]\n" + kCloud), "scene.sun_1"));
  EXPECT_TRUE(says(error("[recipe]\n"), "scene.cloud"));
  EXPECT_TRUE(says(error("volume.fil = 3\n"), "scene.no_key_volume_fil"));
  EXPECT_NE(error(std::string("a = \"\xff\"")).find("s.toml:1:"), std::string::npos);
  EXPECT_THROW((void)read_scene(folder_), Error);
  EXPECT_THROW((void)read_scene(folder_ / "absent.toml"), Error);
}

TEST_F(SceneText, BadSetsAreRefusedWithTheirText) {
  const std::pair<const char*, const char*> cases[] = {
      {"medium.g=2", "scene.set_g_2"},
      {"medium.g", "scene.set_without_value"},
      {"medium.g=", "scene.set_empty_value"},
      {"=3", "scene.set_without_key"},
      {"medium..g=3", "scene.set_two_dots"},
      {"", "scene.set_nothing"},
      {"medium.G=0", "scene.set_no_key_medium_g"},
      {"medium.g=0.5.5", "scene.set_g_0_5_5"},
      {"medium.albedo=[1, 2", "scene.set_value_not_valid"},
      {"medium.albedo=[1, 2, 1]", "scene.set_albedo_2_2"},
      {"volume.grid.x=1", "scene.set_volume_grid_no_keys"},
      {"camera.target=[0, 0, 0]", "scene.set_camera_no_position"},
      {"volume[2].grid=smoke", "scene.set_volume_table_not_list"},
      {"sun[2].angle=1", "scene.set_no_sun"},
      {"sun[0].angle=1", "scene.set_sun_angle"},
      {"sun[1.angle=1", "scene.set_sun_angle_1"},
      {"camera.fov=true", "scene.set_camera_fov_true"},
      {"camera.fov.x=1", "scene.set_camera_fov_number"},
      {"g=0.5", "scene.set_no_key_g"},
  };
  for (const auto& [set, key] : cases) {
    EXPECT_TRUE(says(error("[volume]\nfile = \"cloud.pvol\"\ngrid = \"smoke\"\n", {set}), key))
        << set;
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
      {"[" + many + "]\n", "s.toml:3: "},
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
    EXPECT_TRUE(says(found, "scene.tables_arrays_nest")) << found.substr(0, 200);
  }
  const std::string set = error(kCloud, {many + "=1"}) + error(kCloud, {"a={" + many + "=1}"});
  EXPECT_TRUE(says(set, "scene.tables_arrays_nest"));
}

TEST_F(SceneText, NamesOfKeysAreLimited) {
  const std::string key(5000, 'k');
  EXPECT_TRUE(says(error(kCloud + key + " = 1\n"), "scene.key_bytes_tables"));
}

TEST_F(SceneText, DotsThatAreNoLevelsAreAllowed) {
  std::string text = "# " + path(999) + "\n[camera]\nposition = [0, 0, 0]\ntarget = [";
  for (int i = 0; i < 999; ++i) text += "1.0, ";
  const std::string refusal = error(kCloud + text + "]\n");
  EXPECT_TRUE(says(refusal, "scene.camera_target_array_numbers"));
  std::string forgotten = "[camera]\ntarget = [0, 0, 0\n";
  for (int i = 0; i < 999; ++i) forgotten += "sun.angle = 0.5\n";
  EXPECT_EQ(error(kCloud + forgotten).find("s.toml:5:"), 0u) << error(kCloud + forgotten);
  EXPECT_TRUE(says(error(kCloud + "[" + path(200) + "]\n"), "scene.no_key_a"));
  EXPECT_NE(error(kCloud + "x = \"" + path(999) + "\"\n").find("unknown"), std::string::npos);
}

}  // namespace scene_errors_test
}  // namespace pvol::formats
