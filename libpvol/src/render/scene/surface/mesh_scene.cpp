#include "render/scene/surface/mesh_scene.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>

#include "pvol/error.h"
#include "render/scene/boxes.h"

namespace pvol::detail {
namespace {

/// Of the reach of places: vertices, and where rays begin, are each off by half an ulp of it.
constexpr double kMeshClearance = 0x1p-20;

void require(bool ok, RTCDevice device) {
  if (ok && rtcGetDeviceError(device) == RTC_ERROR_NONE) return;
  throw Error(
      "Embree failed to build the scene's meshes; there may be too little memory for their "
      "triangles");
}

[[nodiscard]] Box world_box(const PlacedMesh& m) {
  Box box;
  for (const Vec3d v : m.mesh->vertices) box = extend(box, m.to_world.point(v));
  return box;
}

}  // namespace

struct MeshScene::Embree {
  RTCDevice device = rtcNewDevice(nullptr);
  RTCScene scene = nullptr;
  std::vector<const float*> vertices;  // of each mesh, three each, around the middle
  std::vector<const std::uint32_t*> triangles;

  Embree() {
    require(device != nullptr, device);
    scene = rtcNewScene(device);
    // Rays do not pass between two triangles that share an edge.
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
  }
  ~Embree() {
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }
  Embree(const Embree&) = delete;
  Embree& operator=(const Embree&) = delete;

  void add(const PlacedMesh& m, Vec3d centre, double scale);
  [[nodiscard]] Vec3d vertex(std::uint32_t mesh, std::uint32_t number, std::size_t corner) const {
    const std::uint32_t* triangle = triangles[mesh] + std::size_t(number) * 3;
    const float* v = vertices[mesh] + std::size_t(triangle[corner]) * 3;
    return {double(v[0]), double(v[1]), double(v[2])};
  }
};

void MeshScene::Embree::add(const PlacedMesh& m, Vec3d centre, double scale) {
  const std::size_t n = m.mesh->vertices.size(), triangle_count = m.mesh->triangles.size();
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* to = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                         RTC_FORMAT_FLOAT3, 3 * sizeof(float), n));
  auto* corners = static_cast<std::uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(std::uint32_t), triangle_count));
  if (to == nullptr || corners == nullptr) {
    rtcReleaseGeometry(geometry);
    require(false, device);
  }
  vertices.push_back(to);
  triangles.push_back(corners);
  for (const Vec3d v : m.mesh->vertices) {
    const Vec3f p((m.to_world.point(v) - centre) * scale);
    for (int axis = 0; axis < 3; ++axis) *to++ = p[axis];
  }
  for (const auto& t : m.mesh->triangles) corners = std::copy(t.begin(), t.end(), corners);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);  // numbered in turn
  rtcReleaseGeometry(geometry);
}

MeshScene::MeshScene(std::span<const PlacedMesh> meshes) {
  for (const PlacedMesh& m : meshes) box_ = join(box_, world_box(m));
  const auto embree = std::make_shared<Embree>();
  embree_ = embree;
  if (box_.empty()) return;
  if (!is_finite(box_.lo) || !is_finite(box_.hi) || !is_finite(box_.extent())) {
    throw Error("the placement of a mesh overflows its coordinates; check its scale and matrix");
  }
  centre_ = box_.centre();
  const double reach = max_component(box_.extent()) * 0.5;
  if (reach > 0) scale_ = std::ldexp(1, -std::clamp(std::ilogb(reach), -1000, 1000));
  for (const PlacedMesh& m : meshes) embree->add(m, centre_, scale_);
  rtcCommitScene(embree->scene);
  require(true, embree->device);
  const Vec3d rim(kMeshClearance * reach);
  box_ = {box_.lo - rim, box_.hi + rim};
}

/// A ray in Embree's frame, from where it enters the box.
struct MeshScene::Query {
  Ray ray;         // in double
  double skipped;  // of t, in the world
  RTCRay embree;
};

std::optional<MeshScene::Query> MeshScene::query(const Ray& ray, double limit) const {
  const auto span = intersect(box_, ray, 0, limit);
  if (!span) return std::nullopt;
  Query q{{(ray.at(span->t0) - centre_) * scale_, ray.d}, span->t0, {}};
  const Vec3f o(q.ray.o), d(q.ray.d);
  q.embree.org_x = o.x, q.embree.org_y = o.y, q.embree.org_z = o.z;
  q.embree.dir_x = d.x, q.embree.dir_y = d.y, q.embree.dir_z = d.z;
  q.embree.tnear = 0;
  q.embree.tfar = float((span->t1 - span->t0) * scale_);
  q.embree.time = 0;
  q.embree.mask = ~0u;
  return q;
}

std::optional<MeshScene::Hit> MeshScene::first_hit(const Ray& ray, double limit) const {
  const auto q = query(ray, limit);
  if (!q) return std::nullopt;
  RTCRayHit found{q->embree, {}};
  found.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(embree_->scene, &context, &found);
  if (found.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  const auto vertex = [&](std::size_t corner) {
    return embree_->vertex(found.hit.geomID, found.hit.primID, corner);
  };
  const Vec3d a = vertex(0), u = vertex(1) - a, v = vertex(2) - a;
  const Vec3d normal = cross(u, v);
  const double exact = dot(normal, a - q->ray.o) / dot(normal, q->ray.d);
  const auto rough = double(found.ray.tfar);
  // Along the triangle the quotient says little.
  const bool near = std::abs(exact - rough) <= 4 * kMeshClearance + 1e-5 * rough;
  const double t = near ? std::max(exact, 0.0) : rough;
  const double clearance = kMeshClearance * (length(q->ray.at(t)) + length(u) + length(v));
  return Hit{q->skipped + t / scale_, normal, clearance / scale_, found.hit.geomID};
}

bool MeshScene::blocks(const Ray& ray, double limit) const {
  auto q = query(ray, limit);
  if (!q) return false;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(embree_->scene, &context, &q->embree);
  return q->embree.tfar < 0;
}

bool MeshScene::may_reach(const Box& box) const {
  if (!meet(box, box_)) return false;
  struct Search {
    const Embree& embree;
    Box box;  // in Embree's frame
    bool found;
  } search{*embree_, {}, false};
  const Vec3d rim(kMeshClearance);  // what vertices and the middle are off by
  search.box = {(box.lo - centre_) * scale_ - rim, (box.hi - centre_) * scale_ + rim};
  const auto look_at = [](RTCPointQueryFunctionArguments* at) {
    auto& s = *static_cast<Search*>(at->userPtr);
    Box triangle;
    for (std::size_t k = 0; k < 3; ++k)
      triangle = extend(triangle, s.embree.vertex(at->geomID, at->primID, k));
    if (!meet(triangle, s.box)) return false;
    s.found = true, at->query->radius = 0;
    return true;  // nothing is nearer than that
  };
  const Vec3f middle(search.box.centre());
  const auto reach = float(length(search.box.extent()));  // twice as far as its corners
  RTCPointQuery query{middle.x, middle.y, middle.z, 0, reach};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(embree_->scene, &query, &context, look_at, &search);
  return search.found;
}

double MeshScene::distance(Vec3d place, double most) const {
  if (box_.empty() || detail::distance(box_, place) >= most) return most;
  struct Search {
    const Embree& embree;
    Vec3d place;  // in Embree's frame, like the distance
    double nearest;
  } search{*embree_, (place - centre_) * scale_, most * scale_};
  // Places far away are off by more than vertices.
  const double rim = kMeshClearance * std::max(1.0, length(search.place));
  const auto look_at = [](RTCPointQueryFunctionArguments* at) {
    auto& s = *static_cast<Search*>(at->userPtr);
    const auto vertex = [&](std::size_t k) { return s.embree.vertex(at->geomID, at->primID, k); };
    const Vec3d a = vertex(0), b = vertex(1), c = vertex(2);
    const Vec3d normal = cross(b - a, c - a);
    const double square = dot(normal, normal);
    const double from_plane =
        square > 0 ? std::abs(dot(s.place - a, normal)) / std::sqrt(square) : 0;
    const double from_box = detail::distance(extend(extend(Box{a, a}, b), c), s.place);
    s.nearest = std::min(s.nearest, std::max(from_plane, from_box));
    at->query->radius = float(s.nearest);
    return true;
  };
  const Vec3f middle(search.place);
  RTCPointQuery query{middle.x, middle.y, middle.z, 0, float(search.nearest + rim)};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(embree_->scene, &query, &context, look_at, &search);
  return std::max(search.nearest - rim, 0.0) / scale_;
}

}  // namespace pvol::detail
