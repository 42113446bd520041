/* A program in C: a volume from an array and, for comparison, from bricks that a function fills;
 * free flights, transmittance, a tracker of its own over segments, and a batch, all against the law
 * of Beer and Lambert. The manual is pvol/pvol.h. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "pvol/pvol.h"

enum { SIZE = 40, RAYS = 100000 };
static const double EXTINCTION = 3;

/* Waves on a slope, equal in y and z. */
static float density(int x) { return 0.001f * (float)x * (1.2f + sinf(0.5f * (float)x)); }

static int fill(void* user, const int32_t origin[3], float* values) {
  int i;
  (void)user;
  for (i = 0; i < 512; ++i) {
    const int x = origin[0] + (i >> 6), y = origin[1] + (i >> 3 & 7), z = origin[2] + (i & 7);
    values[i] = x < SIZE && y < SIZE && z < SIZE ? density(x) : 0;
  }
  return 0;
}

static void complain(void* user, pvol_status status, const char* message) {
  (void)user;
  fprintf(stderr, "pvol failed (%d): %s\n", (int)status, message);
  exit(2);
}

/* Delta tracking by segments and decisions. */
static int passes(const pvol_volume* cloud, const pvol_ray* ray, pvol_random* random) {
  pvol_walk walk;
  pvol_segment s;
  pvol_enter(cloud, ray, &walk);
  while (pvol_next(&walk, &s)) {
    double t = s.t0 - log(1 - pvol_uniform(random)) / s.hi;
    for (; t < s.t1; t -= log(1 - pvol_uniform(random)) / s.hi) {
      if (pvol_walk_exceeds(&walk, t, (float)pvol_uniform(random) * s.hi)) return 0;
    }
  }
  return 1;
}

static int check(const char* what, double found, double exact) {
  const int good = fabs(found - exact) < 0.004;
  printf("%-28s %.4f, exactly %.4f%s\n", what, found, exact, good ? "" : ": WRONG");
  return good;
}

int main(void) {
  float* samples = malloc(sizeof(float) * SIZE * SIZE * SIZE);
  const pvol_ray ray = {{-1, 20, 20}, {2, 0, 0}, INFINITY};
  pvol_volume *cloud = pvol_new_volume(), *same = pvol_new_volume();
  pvol_array array = {0};
  pvol_bricks bricks = {0};
  double depth = 0, exact, sums[4] = {0, 0, 0, 0}, batch = 0;
  int i, good = 1;
  for (i = 0; i < SIZE * SIZE * SIZE; ++i) samples[i] = density(i / (SIZE * SIZE));
  for (i = 0; i < SIZE; ++i) depth += EXTINCTION * (double)density(i);
  exact = exp(-depth);

  if (pvol_api_version() != PVOL_API_VERSION) return 3;
  array.values = samples;
  array.size[0] = array.size[1] = array.size[2] = SIZE;
  pvol_set_error_function(cloud, complain, NULL);
  pvol_set_array(cloud, PVOL_DENSITY, &array);
  pvol_set_extinction(cloud, EXTINCTION);
  pvol_commit(cloud, NULL);
  free(samples);

  bricks.hi[0] = bricks.hi[1] = bricks.hi[2] = SIZE;
  bricks.fill = fill;
  pvol_set_error_function(same, complain, NULL);
  pvol_set_bricks(same, PVOL_DENSITY, &bricks);
  pvol_set_extinction(same, EXTINCTION);
  pvol_commit(same, NULL);

  for (i = 0; i < RAYS; ++i) {
    pvol_random random;
    float passed;
    double t;
    pvol_seed(&random, 1, 0, (uint64_t)i);
    sums[0] += pvol_sample_flight(cloud, &ray, &random, &t) == 0;
    pvol_sample_transmittance(same, &ray, PVOL_RATIO, &random, &passed);
    sums[1] += (double)passed;
    sums[2] += passes(cloud, &ray, &random);
  }
  {
    double* t = malloc(sizeof(double) * RAYS);
    const pvol_streams streams = {2, 0, 0, NULL};
    pvol_rays rays = {0};
    rays.count = RAYS;
    rays.origins.values = ray.o, rays.origins.type = PVOL_DOUBLE;
    rays.directions.values = ray.d, rays.directions.type = PVOL_DOUBLE;
    /* One ray, again and again. */
    rays.origins.component_stride = rays.directions.component_stride = sizeof(double);
    if (pvol_flights(cloud, &rays, &streams, t) != 0) return 4;
    for (i = 0; i < RAYS; ++i) batch += isinf(t[i]) != 0;
    free(t);
  }
  good &= check("flights that leave", sums[0] / RAYS, exact);
  good &= check("ratio tracking", sums[1] / RAYS, exact);
  good &= check("own tracker over segments", sums[2] / RAYS, exact);
  good &= check("flights in a batch", batch / RAYS, exact);
  pvol_release(cloud);
  pvol_release(same);
  return good ? 0 : 1;
}
