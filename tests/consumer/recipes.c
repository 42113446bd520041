/* The recipes of libpvol/EMBEDDING.md, which quotes them, each with a check against what is known. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "pvol/pvol.h"

enum { EDGE = 32 };
static const double EXTINCTION = 0.2, PI = 3.14159265358979;

/* recipe: directions */
static void even_direction(pvol_random* random, double d[3]) {
  const double z = 2 * pvol_uniform(random) - 1, phi = 2 * PI * pvol_uniform(random);
  const double r = sqrt(1 - z * z);
  d[0] = r * cos(phi), d[1] = r * sin(phi), d[2] = z;
}
/* end */

/* recipe: path tracer */
/* Radiance along a ray, under a sky of radiance 1, where collisions scatter evenly. */
static double radiance(const pvol_volume* cloud, const pvol_ray* ray, double albedo,
                       pvol_random* random) {
  pvol_walk walk;
  double t, d[3], weight = 1;
  pvol_enter(cloud, ray, &walk);
  while (pvol_walk_flight(&walk, random, &t)) {
    weight *= albedo;
    if (weight < 0.1) {
      if (pvol_uniform(random) * 0.1 >= weight) return 0;
      weight = 0.1;
    }
    even_direction(random, d);
    pvol_resume(&walk, t, d, INFINITY);
  }
  return weight;
}
/* end */

/* recipe: ray marcher */
/* The optical depth by steps of at most `step`. What segments leave out is empty, and where both
 * bounds are the same nothing needs a look-up. */
static double march(const pvol_volume* cloud, const pvol_ray* ray, double step) {
  pvol_walk walk;
  pvol_segment s;
  double depth = 0;
  pvol_enter(cloud, ray, &walk);
  while (pvol_next(&walk, &s)) {
    const int steps = s.lo == s.hi ? 1 : (int)ceil((s.t1 - s.t0) / step);
    const double length = (s.t1 - s.t0) / steps;
    int i;
    for (i = 0; i < steps; ++i) {
      const double t = s.t0 + (i + 0.5) * length;
      depth += length * (double)(s.lo == s.hi ? s.lo : pvol_walk_extinction(&walk, t));
    }
  }
  return depth;
}
/* end */

/* recipe: single scattering */
/* Light of a distant sun that was scattered once, evenly: one collision, one shadow ray. */
static double scattered_once(const pvol_volume* cloud, const pvol_ray* ray, const double to_sun[3],
                             double irradiance, double albedo, pvol_random* random) {
  pvol_walk walk;
  double t;
  pvol_enter(cloud, ray, &walk);
  if (!pvol_walk_flight(&walk, random, &t)) return 0;
  pvol_resume(&walk, t, to_sun, INFINITY);
  return albedo * irradiance / (4 * PI) *
         (double)pvol_walk_transmittance(&walk, PVOL_RATIO, random);
}
/* end */

/* recipe: photon tracer */
/* Follows a photon until it is absorbed or leaves. Where it is absorbed the power goes to `visit`;
 * the result is what leaves. */
static double trace_photon(const pvol_volume* cloud, const pvol_ray* ray, double albedo,
                           pvol_random* random, void (*visit)(const double place[3], double)) {
  pvol_walk walk;
  double t, place[3], d[3];
  pvol_enter(cloud, ray, &walk);
  while (pvol_walk_flight(&walk, random, &t)) {
    if (pvol_uniform(random) >= albedo) {
      pvol_walk_place(&walk, t, place);
      visit(place, 1);
      return 0;
    }
    even_direction(random, d);
    pvol_resume(&walk, t, d, INFINITY);
  }
  return 1;
}
/* end */

static double absorbed;
static int outside;
static void absorb(const double place[3], double power) {
  int axis;
  absorbed += power;
  for (axis = 0; axis < 3; ++axis) outside += !(place[axis] >= -1 && place[axis] <= EDGE);
}

static int check(const char* what, double found, double exact, double slack) {
  const int good = fabs(found - exact) <= slack;
  printf("%-18s %.5f, exactly %.5f%s\n", what, found, exact, good ? "" : ": WRONG");
  return good;
}

int main(void) {
  enum { PATHS = 200000 };
  pvol_volume* cloud = pvol_new_volume();
  pvol_array array = {0};
  float* samples = malloc(sizeof(float) * EDGE * EDGE * EDGE);
  const pvol_ray ray = {{-2, 15.3, 14.2}, {1, 0.01, 0.02}, INFINITY};
  const double to_sun[3] = {-1, -0.01, -0.02};
  double sums[3] = {0, 0, 0}, depth, left = 0;
  int i, good = 1;
  for (i = 0; i < EDGE * EDGE * EDGE; ++i) samples[i] = 1;
  array.values = samples;
  array.size[0] = array.size[1] = array.size[2] = EDGE;
  pvol_set_array(cloud, PVOL_DENSITY, &array);
  pvol_set_extinction(cloud, EXTINCTION);
  if (pvol_commit(cloud, NULL) != PVOL_OK) {
    fprintf(stderr, "%s\n", pvol_message(cloud));
    return 2;
  }
  free(samples);
  pvol_optical_depth(cloud, &ray, &depth);
  for (i = 0; i < PATHS; ++i) {
    pvol_random random;
    pvol_seed(&random, 1, 2, (uint64_t)i);
    sums[0] += radiance(cloud, &ray, 1, &random);
    sums[1] += scattered_once(cloud, &ray, to_sun, 4 * PI, 1, &random);
    left += trace_photon(cloud, &ray, 0.7, &random, absorb);
  }
  good &= check("path tracer", sums[0] / PATHS, 1, 1e-9);
  good &= check("ray marcher", march(cloud, &ray, 0.05), depth, 0.002 * depth);
  /* The sun is behind the eye: light goes in and comes back the same way. */
  good &= check("single scattering", sums[1] / PATHS, 0.5 * (1 - exp(-2 * depth)), 0.004);
  good &= check("photons", (absorbed + left) / PATHS, 1, 1e-9);
  good &= absorbed > 0.5 * PATHS && left > 0 && outside == 0;
  pvol_release(cloud);
  return good ? 0 : 1;
}
