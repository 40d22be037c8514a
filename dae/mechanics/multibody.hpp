// A mechanical system put together from bodies, joints and forces: coordinates are handed out to bodies,
// groups of elements are added, and the result is a ConstrainedSystem whose patterns are found once and whose
// values are summed by several threads in an order that does not depend on their number.
#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <mfs/options.hpp>

#include "dae/mechanics/constrained_system.hpp"
#include "dae/mechanics/element_group.hpp"

namespace mfs::dae {

/// Coordinates first ... first + count - 1 of the system, those of one body.
struct CoordinateRange {
  int first = 0, count = 0;
};

/// What the coordinates of one body are called and measure.
struct BodyCoordinates {
  std::string name;
  CoordinateRange range;
  std::vector<std::string> components;
  int lengths = 0;  ///< of the components so many, the first, are lengths
  bool is_measure = false;

  /// `i`: from the first coordinate of the body.
  bool is_length(int i) const { return i % std::max(1, static_cast<int>(components.size())) < lengths; }
};

/// Collects the parts; `build` makes the system of them.
class MultibodyBuilder {
 public:
  /// `initial_q`, `initial_v`: count values each. `body` names them in messages, together with `components`,
  /// whose number divides count: three of them make "arm[4].x" of the node 4 (0-based) of a mesh; none,
  /// "arm[12]". The first `lengths` components are lengths; the others have no unit. Throws
  /// InvalidInput("body NAME") where the numbers are not finite or do not fit together.
  CoordinateRange add_coordinates(const std::string& body, const std::vector<double>& initial_q,
                                  const std::vector<double>& initial_v,
                                  const std::vector<std::string>& components = {}, int lengths = 0);
  /// One that a constraint, to be added, makes a function of others (ConstrainedSystem::is_measure). Returns
  /// its number; throws as above.
  int add_measure_coordinate(const std::string& name, double initial_q, double initial_v, bool is_length);
  void add(std::shared_ptr<const ElementGroup> group);

  /// A body, that with the first coordinate `body`, has an arm, a radius or an extent of this length.
  void note_length(int body, double length);
  /// What lengths are measured in inside of the integrator: 1 where one of the bodies has an ordinary size,
  /// otherwise the power of two nearest to that size which is nearest to an ordinary one. So a mechanism in
  /// micrometres is to the integrator what it is in metres.
  double length_unit() const;
  /// The largest size of a body; 1 where none has one.
  double largest_body() const;

  const std::vector<std::shared_ptr<const ElementGroup>>& groups() const { return groups_; }
  /// Of all groups so far: the next one's first.
  int constraints() const { return constraints_; }
  const std::vector<double>& initial_q() const { return q_; }
  const std::vector<double>& initial_v() const { return v_; }

  /// `threads` 0: all that the machine offers. With Backend::cuda groups that can are evaluated on the device
  /// where that is implemented: F of flexible bodies and its derivatives, which are remote tangents; the rest
  /// stays on the host. The system's functions may not be called at the same time by several threads: they
  /// share the room for the elements' matrices. What an element throws they pass on; where several throw,
  /// always the same one's.
  /// Throws InvalidInput where an element names a coordinate that is not there, or one twice; with
  /// Backend::cuda BackendError where there is no device, and OutOfMemory.
  std::unique_ptr<ConstrainedSystem> build(int threads = 0, Backend backend = Backend::openmp) const;

 private:
  std::vector<BodyCoordinates> bodies_;
  std::vector<double> q_, v_;
  std::vector<std::shared_ptr<const ElementGroup>> groups_;
  int constraints_ = 0;
  std::map<int, double> size_;  ///< of bodies: the largest of their lengths
};

}  // namespace mfs::dae
