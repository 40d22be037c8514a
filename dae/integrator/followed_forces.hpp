// Which forces corrections of Newton's method have to bring to rest by themselves, however large others are:
// friction may be among them. A body that is stuck in friction as steep as the tolerance is held by whatever
// pulls at it, as long as nobody looks at the force (newton_progress.hpp), and beside stiff bodies, whose
// forces are large for small errors, it is not seen in the largest of all.
#pragma once

#include <vector>

#include "dae/mechanics/constrained_system.hpp"

namespace mfs::dae {

/// n; 1 for measures and for what their rates push, else 0. Expressions know rates by measures alone.
std::vector<double> followed_forces(const ConstrainedSystem& system);

}  // namespace mfs::dae
