// A part of time.
#pragma once

namespace mfs::dae {

struct TimeSpan {
  double begin = 0.0, end = 0.0;
};

}  // namespace mfs::dae
