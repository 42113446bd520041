/* Clouds for renderers, in C: a volume from samples in memory, then free flights, transmittance,
 * segments and look-ups along rays of the world, one at a time or many at once. It needs C99, or
 * C++17, for which pvol/pvol.hpp has the same with owners and spans. What is more than this, in
 * C++20, is in pvol/embed.h and pvol/trackers.h.
 *
 *   pvol_volume* cloud = pvol_new_volume();
 *   const pvol_array samples = {.values = data, .size = {nx, ny, nz}};
 *   pvol_set_array(cloud, PVOL_DENSITY, &samples);
 *   pvol_set_extinction(cloud, 4);                    // mu_t = 4 x density
 *   if (pvol_commit(cloud, NULL) != PVOL_OK) puts(pvol_message(cloud));
 *
 *   // For each ray, on any thread: where it collides, and how much of the light comes through.
 *   pvol_random random;
 *   pvol_seed(&random, seed, pixel, sample);
 *   const pvol_ray ray = {{ox, oy, oz}, {dx, dy, dz}, t_max};
 *   double t;
 *   if (pvol_sample_flight(cloud, &ray, &random, &t) == 1) { ... a collision at t ... }
 *   float passed;
 *   pvol_sample_transmittance(cloud, &shadow_ray, PVOL_RATIO, &random, &passed);
 *
 *   pvol_release(cloud);
 *
 * Units. Lengths are in world units, mu_t is per world unit, optical depths have no unit. t is the
 * distance from the ray's origin, whatever the length of its direction.
 *
 * Zero is a default. All structures may be cleared by {0} or memset; members called `reserved` are
 * to stay 0, so that later versions can give them a meaning.
 *
 * Errors. Calls that make something return a pvol_status; pvol_message has a sentence about the
 * last that failed on that volume, and a function of yours may be told at once
 * (pvol_set_error_function). Calls for rays return 1, 0 or PVOL_BAD_RAY and nothing else happens,
 * so that no message floods a render's threads: a bad ray is one that is not finite, has no
 * direction or a t_max that is no number, as any volume that was not committed is bad for all rays.
 * A null pointer is refused likewise, where its declaration does not say what it means: with
 * PVOL_INVALID, as a bad ray, or, in batches, with all results no number. (Not checked are arguments
 * of pvol_seed, pvol_uniform and of calls that go on with a walk, and `numbers` of a pvol_random
 * that counts some.) Nothing throws or exits.
 *
 * Threads. Once committed, a volume may be used by any number of threads at once. Setters, commit
 * and the message are for one thread at a time, while no other uses the volume. A pvol_walk and a
 * pvol_random belong to one thread; they own nothing and may be copied by assignment.
 *
 * Versions. PVOL_API_VERSION counts changes of this header that programs must know of; a program
 * may compare it with pvol_api_version() of the library that it found. Within a version functions,
 * enumerators and meanings are only added. */
#ifndef PVOL_PVOL_H
#define PVOL_PVOL_H

#include <stddef.h>
#include <stdint.h>

#define PVOL_API_VERSION 1

/* The type of enumerations in C++, so that numbers which are none of theirs can be refused: C may
 * pass any. */
#ifdef __cplusplus
#define PVOL_INT : int
extern "C" {
#else
#define PVOL_INT
#endif

/* ---- 1. Volumes ------------------------------------------------------------------------------ */

typedef enum pvol_status PVOL_INT {
  PVOL_OK = 0,
  PVOL_INVALID = 1, /* an argument or the data are not as they must be; the message says what */
  PVOL_NO_MEMORY = 2,
  PVOL_CANCELLED = 3, /* by pvol_cancel, a progress function or a function that fills bricks */
  PVOL_FAILED = 4     /* something else; the message says what */
} pvol_status;

/* What rays return instead of 1 and 0. */
#define PVOL_BAD_RAY (-1)

/* The API's version that the library was built with, and its own version, such as "0.2.0". */
int pvol_api_version(void);
const char* pvol_version(void);

typedef struct pvol_volume pvol_volume;

/* A volume without density, with one reference; null where there is no memory. */
pvol_volume* pvol_new_volume(void);
/* One reference more, and one less; with the last the volume goes. Null is no error. */
void pvol_retain(pvol_volume* volume);
void pvol_release(pvol_volume* volume);

/* About the last call on the volume that failed, in English, with what was found, what was expected
 * and what to do; "" before. Valid until the next call that returns a pvol_status. */
const char* pvol_message(const pvol_volume* volume);

typedef void (*pvol_error_function)(void* user, pvol_status status, const char* message);
/* Is called, on the thread of the call, where one that returns a pvol_status fails. Null: nobody.
 */
pvol_status pvol_set_error_function(pvol_volume* volume, pvol_error_function function, void* user);

/* ---- 2. What it is made of ------------------------------------------------------------------- */

/* Fields by number. Rays collide with the density; those above are for pvol_value alone, such as a
 * temperature, and need not be there. */
enum { PVOL_DENSITY = 0, PVOL_MOST_FIELDS = 16 };

typedef enum pvol_type PVOL_INT { PVOL_FLOAT = 0, PVOL_DOUBLE = 1, PVOL_HALF = 2 } pvol_type;

/* Samples in an array: that of lattice point origin + (i, j, k), 0 <= (i, j, k) < size, lies
 * i stride[0] + j stride[1] + k stride[2] bytes behind `values`. All strides 0: values[i][j][k] of
 * C, k fastest. Each sample is finite and not negative. */
typedef struct pvol_array {
  const void* values;
  int32_t size[3];
  int32_t origin[3];
  int64_t stride[3];
  pvol_type type;
  uint32_t reserved[3];
} pvol_array;

/* Samples by bricks of 8^3, for what no array could hold. `fill` is called from several threads at
 * once for every brick that holds a lattice point of lo <= p < hi, and writes sample (i, j, k) of
 * the brick at `origin` to values[(i * 8 + j) * 8 + k], over zeros; origins are multiples of 8. It
 * returns 0; anything else gives up. */
typedef struct pvol_bricks {
  int32_t lo[3], hi[3];
  int (*fill)(void* user, const int32_t origin[3], float* values);
  void* user;
  uint32_t reserved[4];
} pvol_bricks;

/* Samples as sparse trees have them: leaves of 8^3, in the order of bricks, and cubes of one value,
 * whose edge is 8, 128 or 4096; origins are multiples of the edge. All are disjoint, in any order;
 * what lies in none of them is 0. */
typedef struct pvol_leaf {
  const float* values;
  int32_t origin[3];
} pvol_leaf;
typedef struct pvol_tile {
  int32_t origin[3];
  int32_t edge;
  float value;
} pvol_tile;
typedef struct pvol_leaves {
  const pvol_leaf* leaves;
  size_t leaf_count;
  const pvol_tile* tiles;
  size_t tile_count;
  uint32_t reserved[4];
} pvol_leaves;

/* The field's samples, instead of those that it had. They are read by the next commit and may go
 * once one has succeeded, or others are set. Interpolation cells lie between samples, and the field
 * reaches one cell beyond the outermost. */
pvol_status pvol_set_array(pvol_volume* volume, int field, const pvol_array* array);
pvol_status pvol_set_bricks(pvol_volume* volume, int field, const pvol_bricks* bricks);
pvol_status pvol_set_leaves(pvol_volume* volume, int field, const pvol_leaves* leaves);
/* The same for the density, whose samples stay where they are: look-ups read them there, with the
 * same results, in less memory and somewhat more time, and batches go ray by ray. An array holds
 * floats. They must stay, unchanged, as long as the volume may look: until a commit of others has
 * succeeded, or the volume is released. For nearest and trilinear interpolation. */
pvol_status pvol_share_array(pvol_volume* volume, int field, const pvol_array* array);
pvol_status pvol_share_leaves(pvol_volume* volume, int field, const pvol_leaves* leaves);
/* Without samples again. */
pvol_status pvol_clear_field(pvol_volume* volume, int field);

/* Of the field's new samples, those at lattice points lo <= p < hi are the only ones that differ
 * from the last commit's; called again, those in any of the boxes. For the density, the next commit
 * then reads these alone and costs what they do (nearest and trilinear, without tiles or a shell
 * and not shared; else it reads all). Setting samples forgets the boxes; a commit that fails keeps
 * them, and one of a field whose samples were not set anew, though it has boxes, is invalid. */
pvol_status pvol_set_changed(pvol_volume* volume, int field, const int32_t lo[3],
                             const int32_t hi[3]);

/* From lattice points to the world, by rows: x = m[0] i + m[1] j + m[2] k + m[3] and so on.
 * Without: they are the same. */
pvol_status pvol_set_transform(pvol_volume* volume, int field, const double m[12]);

/* mu_t per world unit and unit of density, 0 or more; 1 without. */
pvol_status pvol_set_extinction(pvol_volume* volume, double extinction);
/* The share of it by channel, each in [0, 1] and the largest 1, for pvol_flight_rgb and
 * pvol_transmittance_rgb; all else sees the largest. */
pvol_status pvol_set_extinction_color(pvol_volume* volume, const float share[3]);

typedef enum pvol_interpolation PVOL_INT {
  PVOL_TRILINEAR = 0,
  PVOL_NEAREST = 1,
  PVOL_TRICUBIC = 2 /* the uniform B-spline: smooth, and never above the samples around */
} pvol_interpolation;
/* Of the density. Other fields are trilinear. */
pvol_status pvol_set_interpolation(pvol_volume* volume, pvol_interpolation interpolation);

/* 1: the next commit fits a shell around the density, for pvol_shell_spans (seconds for a large
 * cloud); 0: none, as without. Set the density's samples again where a commit has released them. */
pvol_status pvol_set_shell(pvol_volume* volume, int wanted);

typedef struct pvol_commit_options {
  /* Threads that work on it at most; 0: all of the machine, or those of the arena. */
  int32_t threads;
  /* Called as the commit goes on, on its thread or one of the arena's; `done` rises from 0 to 1.
   * Another result than 0 cancels the commit. */
  int (*progress)(void* user, double done);
  void* user;
  /* An oneapi::tbb::task_arena of yours, in which to work; null: that of the caller. With a number
   * of threads it is not used. */
  void* arena;
  uint64_t reserved[4];
} pvol_commit_options;

/* Bounds what was set and makes it ready for rays. Until this has succeeded once the volume is bad
 * for rays; where it fails or is cancelled it stays as it was committed before. Samples that need
 * more memory than is free are refused with PVOL_NO_MEMORY: those of an array by a part of them
 * before they are read, others as they are. Options may be null.
 *
 * A volume may be set anew and committed again, frame by frame. Fields that were not set since the
 * last commit keep their samples, whose memory may be gone unless it is shared, and cost nothing;
 * where nothing but the extinction or a transform changed, neither is the density bounded again.
 * Walks of before are void. */
pvol_status pvol_commit(pvol_volume* volume, const pvol_commit_options* options);

/* From any thread that has a reference: the commit under way, if there is one, soon returns
 * PVOL_CANCELLED. */
void pvol_cancel(pvol_volume* volume);

/* ---- 3. What is known of it ------------------------------------------------------------------ */

/* The box of the world outside which the density is 0. Returns 0, and no box, where it is 0
 * everywhere. */
int pvol_box(const pvol_volume* volume, double lo[3], double hi[3]);
/* Bounds of mu_t in a box of the world: range[0] <= mu_t <= range[1]. As tight as leaves of 8^3
 * cells; above the box of one leaf, coarser where that takes fewer steps. Returns PVOL_BAD_RAY for
 * a box that is not one. */
int pvol_extinction_range(const pvol_volume* volume, const double lo[3], const double hi[3],
                          float range[2]);
/* Bytes of memory that the volume takes for samples and bounds, without those that are shared. */
uint64_t pvol_bytes(const pvol_volume* volume);

/* The density, mu_t, and a field's value at a place of the world; 0 outside, and where the place is
 * null or not finite. The density is 0 as well where mu_t is, under an extinction of 0. */
float pvol_density(const pvol_volume* volume, const double place[3]);
float pvol_extinction(const pvol_volume* volume, const double place[3]);
float pvol_value(const pvol_volume* volume, int field, const double place[3]);

/* ---- 4. Random numbers ----------------------------------------------------------------------- */

/* Where a call's random numbers come from. Cleared, or after pvol_seed: from a stream of pvol's
 * own, that of the key, from `used` on; equal streams are equal on any thread and machine. With
 * `numbers` the first `count` of them are those of yours, such as a stratified sample of few
 * dimensions, and the stream's follow. With `next` all are yours.
 *
 * Numbers are uniform in [0, 1). Each tentative collision takes two, a depth and then a decision;
 * so the first of a flight is stratified best. From floats, depths have the resolution of their
 * grid: with 24 bits nothing collides before an optical depth of 6e-8. What lies outside [0, 1) is
 * taken for the nearest number in it, and what is no number for 0; a function that returns 0 for
 * ever keeps a flight where it is for ever. */
typedef struct pvol_random {
  uint64_t key[2];
  uint64_t used; /* of the stream: blocks of two numbers */
  const float* numbers;
  uint32_t count;
  uint32_t taken; /* of `numbers` */
  double (*next)(void* user);
  void* user;
} pvol_random;

/* The stream of these three, such as seed, pixel and sample, from its start; without other numbers.
 */
void pvol_seed(pvol_random* random, uint64_t seed, uint64_t stream, uint64_t sample);
/* The next number, for uses of your own. */
double pvol_uniform(pvol_random* random);

/* ---- 5. One call a ray ----------------------------------------------------------------------- */

/* o + t d, 0 <= t <= t_max, which may be infinite. Of any finite direction but 0. */
typedef struct pvol_ray {
  double o[3], d[3];
  double t_max;
} pvol_ray;

/* Estimators of the transmittance, all without bias. */
typedef enum pvol_estimator PVOL_INT {
  PVOL_RATIO = 0,          /* in [0, 1]; suits most rays */
  PVOL_ANALOG = 1,         /* 0 or 1; cheap in thick clouds */
  PVOL_RESIDUAL_RATIO = 2, /* what lies below the minorants in closed form */
  PVOL_EXACT = 3           /* exp(-depth) in closed form, cell by cell; not for tricubic */
} pvol_estimator;

/* 1: the next collision is at *t, with density mu_t(t) exp(-int_0^t mu_t). 0: the ray gets through.
 */
int pvol_sample_flight(const pvol_volume* volume, const pvol_ray* ray, pvol_random* random,
                       double* t);
/* 1, and an estimate of the transmittance up to t_max, in [0, 1] give or take rounding;
 * PVOL_BAD_RAY for PVOL_EXACT in tricubic volumes too. */
int pvol_sample_transmittance(const pvol_volume* volume, const pvol_ray* ray,
                              pvol_estimator estimator, pvol_random* random, float* transmittance);
/* 1, and the optical depth up to t_max in closed form; PVOL_BAD_RAY for tricubic volumes too. */
int pvol_optical_depth(const pvol_volume* volume, const pvol_ray* ray, double* depth);

/* ---- 6. Segments, and trackers of your own --------------------------------------------------- */

/* A piece of a ray in which lo <= mu_t <= hi, hi > 0. */
typedef struct pvol_segment {
  double t0, t1;
  float lo, hi;
} pvol_segment;

/* Where a ray is on its way through a volume. Yours to keep; no part of it is yours to read. It
 * refers to the volume. */
typedef union pvol_walk {
  uint64_t reserved[64];
  long double aligned; /* to 16 bytes */
} pvol_walk;

/* 1: the walk is at the start of the ray's way through the volume's box. 0: the ray misses it, and
 * the walk has no segments. */
int pvol_enter(const pvol_volume* volume, const pvol_ray* ray, pvol_walk* walk);
/* 1, and the next segment: in order, apart, within [0, t_max]; between them mu_t is 0. 0 at the
 * end. */
int pvol_next(pvol_walk* walk, pvol_segment* segment);

/* The density and mu_t at t of the current segment, without a search from the top. Rounding may
 * lift mu_t above the segment's hi by 3 units in the last place. */
float pvol_walk_density(const pvol_walk* walk, double t);
float pvol_walk_extinction(const pvol_walk* walk, double t);
/* Whether mu < mu_t at t of the current segment: as pvol_walk_extinction would say, often without
 * the look-up. A tentative collision at the rate hi is real where u hi < mu_t. */
int pvol_walk_exceeds(const pvol_walk* walk, double t, float mu);

/* A flight from where the walk is to its end: 1, and a collision at *t, which is in the current
 * segment then, and from where pvol_resume goes on; 0: the ray gets through, and the walk is at its
 * end. */
int pvol_walk_flight(pvol_walk* walk, pvol_random* random, double* t);
/* An estimate of the transmittance of what lies ahead of the walk, which is used up by it. */
float pvol_walk_transmittance(pvol_walk* walk, pvol_estimator estimator, pvol_random* random);
/* Likewise; no number in tricubic volumes. */
double pvol_walk_optical_depth(pvol_walk* walk);

/* 1: the walk goes on in a new direction from t of the current segment, such as a collision's
 * place; t counts from there. No search, and no loss of digits along long paths. */
int pvol_resume(pvol_walk* walk, double t, const double direction[3], double t_max);

/* The place in the world at t of the current segment; no numbers where a walk has none. */
void pvol_walk_place(const pvol_walk* walk, double t, double place[3]);

/* Flights and transmittance where channels differ in their extinction (pvol_set_extinction_color):
 * one flight for all. `throughput` is what the path carries, by which decisions are weighed, so
 * that its product with the weights never grows; multiply it by `weight`, also where the result is
 * 0. */
int pvol_walk_flight_rgb(pvol_walk* walk, const float throughput[3], pvol_random* random, double* t,
                         float weight[3]);
void pvol_walk_transmittance_rgb(pvol_walk* walk, pvol_random* random, float transmittance[3]);

/* ---- 7. The shell ---------------------------------------------------------------------------- */

typedef struct pvol_span {
  double t0, t1;
} pvol_span;
/* Where the ray is inside the volume's shell, which holds all of the density: the first `capacity`
 * spans, in order. Returns how many there are, none where it misses; where the volume has no shell,
 * those of its box. PVOL_BAD_RAY for a bad ray, and where there is no memory for spans. */
int pvol_shell_spans(const pvol_volume* volume, const pvol_ray* ray, pvol_span* spans,
                     int capacity);

/* ---- 8. Many rays at once -------------------------------------------------------------------- */

/* Vectors of three numbers, floats or doubles: component c of vector i lies
 * i stride + c component_stride bytes behind `values`. Both 0: packed, x y z x y z. */
typedef struct pvol_vectors {
  const void* values;
  int64_t stride, component_stride;
  pvol_type type;
  uint32_t reserved;
} pvol_vectors;

/* Rays as in pvol_ray. t_max is like one component of vectors; without values: infinite. */
typedef struct pvol_rays {
  size_t count;
  pvol_vectors origins, directions, t_max;
} pvol_rays;

/* Ray i draws its numbers from the stream of pvol_seed(seed, stream, sample), where the stream is
 * streams[i], or first + i without an array: nothing else in the batch has a say in its result. */
typedef struct pvol_streams {
  uint64_t seed, first, sample;
  const uint64_t* streams;
} pvol_streams;

/* A flight of each ray, many at a time in the lanes of the processor's registers: t[i] is the place
 * of the collision, infinite where there is none, and no number for a bad ray.
 *
 * Its distribution is that of pvol_sample_flight. Its value by the same stream often is not: lanes
 * draw tentative collisions by bounds of small cubes, single calls by those of a tree. Lanes of any
 * width give the same values, but for those of SSE 4.1, which round products first. Batches go ray
 * by ray, and give the values of single calls, on processors without SSE 4.1 or NEON, and through
 * shared samples and the largest and thickest clouds: of more than 16 000 samples along an axis, of
 * more than 2^24 leaves of 8^3 in their box of which less than 1/64 are occupied, of some millions
 * that are, or with mean free paths of less than some thousandths of the distance between samples.
 *
 * Works on the thread that calls, which keeps 220 KB for it until it ends; share a large batch
 * among threads of yours. Returns how many rays were bad; all where the volume was not committed,
 * and where there is no memory. */
size_t pvol_flights(const pvol_volume* volume, const pvol_rays* rays, const pvol_streams* streams,
                    double* t);
/* The same for transmittances, by PVOL_RATIO or PVOL_ANALOG in lanes, by others one by one with the
 * values of pvol_sample_transmittance. */
size_t pvol_transmittances(const pvol_volume* volume, const pvol_rays* rays,
                           pvol_estimator estimator, const pvol_streams* streams,
                           float* transmittance);
size_t pvol_optical_depths(const pvol_volume* volume, const pvol_rays* rays, double* depth);

#ifdef __cplusplus
}
#endif

#endif
