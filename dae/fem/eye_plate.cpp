#include "dae/fem/eye_plate.hpp"

#include <algorithm>
#include <cmath>
#include <mfs/error.hpp>

namespace mfs::dae {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kCellsAcross = 2;             // of a bar
constexpr int kCellsRadial = 1;             // of a ring
constexpr double kFreeCellAngle = kPi / 4;  // of a ring where no bar is

Point2 on_circle(const Point2& center, double radius, double angle) {
  return {center[0] + radius * std::cos(angle), center[1] + radius * std::sin(angle)};
}

Point2 between(const Point2& a, const Point2& b, double t) {
  return {(1 - t) * a[0] + t * b[0], (1 - t) * a[1] + t * b[1]};
}

// Part of a ring, counter-clockwise. Free ones end at the outer circle, those with a bar at its chord: the
// sides of bars leave along the tangents, so between circle and side there is no angle left for a cell,
// beside the chord there is that of the tangent with it.
struct Sector {
  double begin, end;
  int cells;
  bool bar;
};

double direction(const EyePlate& plate, const Bar& bar) {
  const Point2 &a = plate.eyes[bar.first].center, &b = plate.eyes[bar.second].center;
  return std::atan2(b[1] - a[1], b[0] - a[0]);
}

// The sectors where bars leave eye e, and the free ones between them.
std::vector<Sector> sectors(const EyePlate& plate, std::size_t e) {
  std::vector<Sector> taken;
  for (const Bar& bar : plate.bars) {
    if (bar.first != e && bar.second != e) continue;
    const double half = bar.first == e ? bar.first_half_angle : bar.second_half_angle;
    const double middle = std::remainder(direction(plate, bar) + (bar.first == e ? 0 : kPi), 2 * kPi);
    taken.push_back({middle - half, middle + half, kCellsAcross, true});
  }
  std::sort(taken.begin(), taken.end(), [](const Sector& a, const Sector& b) { return a.begin < b.begin; });
  std::vector<Sector> all;
  for (std::size_t i = 0; i < taken.size(); ++i) {
    all.push_back(taken[i]);
    const double next = i + 1 < taken.size() ? taken[i + 1].begin : taken[0].begin + 2 * kPi;
    const double angle = next - taken[i].end;
    if (angle <= 0) throw InvalidInput(plate.name, "bars overlap around " + plate.eyes[e].hole_set);
    all.push_back(
        {taken[i].end, next, std::max(1, static_cast<int>(std::lround(angle / kFreeCellAngle))), false});
  }
  return all;
}

void add_ring(const EyePlate& plate, std::size_t e, int refine, PlaneMesh& mesh) {
  const Eye& eye = plate.eyes[e];
  for (const Sector& sector : sectors(plate, e)) {
    const auto map = [&](double s, double t) {
      const double angle = sector.begin + t * (sector.end - sector.begin);
      const Point2 inner = on_circle(eye.center, eye.hole, angle);
      const Point2 outer = sector.bar ? between(on_circle(eye.center, eye.radius, sector.begin),
                                                on_circle(eye.center, eye.radius, sector.end), t)
                                      : on_circle(eye.center, eye.radius, angle);
      return between(inner, outer, s);
    };
    mesh.add_to_set(eye.hole_set, mesh.add_patch(kCellsRadial * refine, sector.cells * refine, map));
  }
}

// Cubic from a to b (Hermite) that leaves and arrives in the given directions with speeds that are short
// against the distance, so that it bends near the ends.
struct Side {
  Point2 a, b, leave, arrive;

  Point2 operator()(double s) const {
    Point2 x;
    for (std::size_t k = 0; k < 2; ++k)
      x[k] = (1 + 2 * s) * (1 - s) * (1 - s) * a[k] + s * s * (3 - 2 * s) * b[k] +
             s * (1 - s) * (1 - s) * leave[k] - s * s * (1 - s) * arrive[k];
    return x;
  }
};

// The patch between the chords of its two eyes and two sides, ruled across.
void add_bar(const EyePlate& plate, const Bar& bar, int refine, PlaneMesh& mesh) {
  const Eye &first = plate.eyes[bar.first], &second = plate.eyes[bar.second];
  const double along = direction(plate, bar);
  const auto side = [&](double sign) {  // -1: clockwise of the middle of the first eye, 1: the other
    const double leave = along + sign * bar.first_half_angle,
                 arrive = along + kPi - sign * bar.second_half_angle;
    return Side{on_circle(first.center, first.radius, leave), on_circle(second.center, second.radius, arrive),
                on_circle({0, 0}, first.radius, leave - sign * kPi / 2),
                on_circle({0, 0}, second.radius, arrive - sign * kPi / 2)};
  };
  const Side lower = side(-1), upper = side(1);
  mesh.add_patch(bar.cells_along * refine, kCellsAcross * refine,
                 [&](double s, double t) { return between(lower(s), upper(s), t); });
}

void check(const EyePlate& plate, int refine) {
  if (refine < 1) throw InvalidInput("refine", "must be 1 at least");
  if (!(plate.thickness > 0)) throw InvalidInput(plate.name, "thickness must be positive");
  for (const Eye& eye : plate.eyes)
    if (!(eye.hole > 0 && eye.hole < eye.radius))
      throw InvalidInput(plate.name, eye.hole_set + " must be positive and smaller than the ring around it");
  for (std::size_t i = 0; i < plate.eyes.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const Eye &a = plate.eyes[i], &b = plate.eyes[j];
      if (!(std::hypot(a.center[0] - b.center[0], a.center[1] - b.center[1]) > a.radius + b.radius))
        throw InvalidInput(plate.name, "rings around " + b.hole_set + " and " + a.hole_set + " overlap");
    }
}

}  // namespace

Mesh eye_plate_mesh(const EyePlate& plate, int refine, ElementKind kind) {
  check(plate, refine);
  double smallest = plate.eyes[0].hole;
  for (const Eye& eye : plate.eyes) smallest = std::min(smallest, eye.hole);
  const auto plane = [&](int cells) {
    PlaneMesh mesh(1e-6 * smallest);
    for (std::size_t e = 0; e < plate.eyes.size(); ++e) add_ring(plate, e, cells, mesh);
    for (const Bar& bar : plate.bars) add_bar(plate, bar, cells, mesh);
    return mesh;
  };
  check_cell_count(1.0 * plane(1).cells() * plate.layers * refine * refine * refine, kind);
  return plane(refine).extrude(plate.thickness, plate.layers * refine, kind);
}

}  // namespace mfs::dae
