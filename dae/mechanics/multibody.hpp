// A mechanical system put together from bodies, joints and forces: coordinates are handed out to bodies,
// groups of elements are added, and the result is a ConstrainedSystem whose patterns are found once and whose
// values are summed by several threads in an order that does not depend on their number.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "dae/mechanics/constrained_system.hpp"
#include "dae/mechanics/element_group.hpp"

namespace mfs::dae {

/// Coordinates first ... first + count - 1 of the system, those of one body.
struct CoordinateRange {
  int first = 0, count = 0;
};

/// Collects the parts; `build` makes the system of them.
class MultibodyBuilder {
 public:
  /// `initial_q`, `initial_v`: count values each; `scale`: a typical size of these coordinates (metres, or
  /// 1). `body` names them in messages.
  CoordinateRange add_coordinates(const std::string& body, const std::vector<double>& initial_q,
                                  const std::vector<double>& initial_v, double scale = 1.0);
  void add(std::shared_ptr<const ElementGroup> group);

  const std::vector<double>& initial_q() const { return q_; }
  const std::vector<double>& initial_v() const { return v_; }

  /// `threads` 0: all that the machine offers. Throws InvalidInput where a group names a coordinate that is
  /// not there, or names one twice in an element.
  std::unique_ptr<ConstrainedSystem> build(int threads = 0) const;

 private:
  struct Body {
    std::string name;
    CoordinateRange range;
    double scale;
  };
  std::vector<Body> bodies_;
  std::vector<double> q_, v_;
  std::vector<std::shared_ptr<const ElementGroup>> groups_;
};

}  // namespace mfs::dae
