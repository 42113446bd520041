#include "render/light/emission/emission_lights.h"

#include <algorithm>
#include <cmath>

namespace pvol::detail {

PlacedPower::PlacedPower(const EmissionSource& source, std::shared_ptr<const PowerBoxes> boxes)
    : source_(source), boxes_(std::move(boxes)), still_(place_at(0)) {}

PlacedPower::Place PlacedPower::place_at(float time) const {
  const Affine to_cells = source_.field->world_to_cells * source_.to_first_at(time);
  const Affine to_world = inverse(to_cells);
  const Box& bounds = boxes_->bounds();
  const Vec3d corner = to_world.vector((bounds.hi - bounds.lo) * 0.5);
  return {to_cells, std::abs(determinant(to_world)), to_world.point(bounds.centre()),
          dot(corner, corner)};
}

double PlacedPower::seen_from(Vec3d place, const Place& own) const {
  const Vec3d away = place - own.centre;
  return own.cell_volume * boxes_->power() / std::max(dot(away, away), own.reach);
}

Vec3d PlacedPower::sample(Vec3d place, const Place& own, Rng& rng) const {
  return inverse(own.to_cells).point(boxes_->sample(own.to_cells.point(place), rng));
}

Vec3d PlacedPower::sample(Rng& rng) const {
  return inverse(still_.to_cells).point(boxes_->sample(rng));
}

double PlacedPower::pdf(Vec3d place, Vec3d d, const Place& own) const {
  return boxes_->pdf({own.to_cells.point(place), own.to_cells.vector(d)}, own.cell_volume);
}

EmissionLights::EmissionLights(const std::vector<EmissionSource>& sources) {
  std::shared_ptr<const PowerBoxes> boxes;
  const VolumeField* of = nullptr;
  for (const EmissionSource& s : sources) {
    if (s.field != of) boxes = std::make_shared<const PowerBoxes>(s);
    of = s.field;
    if (!boxes->dark()) lights_.emplace_back(s, boxes);
  }
}

EmissionLights::Towards EmissionLights::sample(Vec3d place, float time, Rng& rng) const {
  PlacedPower::Place moved;
  const auto seen = [&](std::size_t k) {
    return lights_[k].seen_from(place, lights_[k].at(time, moved));
  };
  double sum = 0;
  for (std::size_t k = 0; k < lights_.size(); ++k) sum += seen(k);
  if (!(sum > 0)) return {};
  std::size_t k = 0;
  if (lights_.size() > 1) {
    double left = double(rng.uniform()) * sum;
    while (k + 1 < lights_.size() && !(left < seen(k))) left -= seen(k++);
  }
  const Vec3d way = lights_[k].sample(place, lights_[k].at(time, moved), rng) - place;
  const double distance = length(way);
  if (!(distance > 0)) return {};
  const Vec3f d(way / distance);
  return {d, pdf(place, d, time)};
}

double EmissionLights::power() const {
  double sum = 0;
  for (const PlacedPower& l : lights_) sum += l.power();
  return sum;
}

Vec3d EmissionLights::sample(Rng& rng) const {
  double left = double(rng.uniform()) * power();
  std::size_t k = 0;
  while (k + 1 < lights_.size() && !(left < lights_[k].power())) left -= lights_[k++].power();
  return lights_[k].sample(rng);
}

Vec3d EmissionLights::centre() const {
  const double all = power();
  Vec3d sum;
  for (const PlacedPower& l : lights_) sum += l.centre() * (l.power() / all);
  return sum;
}

float EmissionLights::pdf(Vec3d place, Vec3f direction, float time) const {
  double sum = 0, density = 0;
  PlacedPower::Place moved;
  for (const PlacedPower& l : lights_) {
    const PlacedPower::Place& own = l.at(time, moved);
    const double seen = l.seen_from(place, own);
    if (!(seen > 0)) continue;
    sum += seen;
    density += seen * l.pdf(place, Vec3d(direction), own);
  }
  return sum > 0 ? float(density / sum) : 0;
}

}  // namespace pvol::detail
